// One u16 (vertices), then any bytes as a colour payload; what is accepted colours a chain of vertices.
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/colour_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace anyrate;
    try {
        ByteReader in(std::as_bytes(std::span(data, size)), "input");
        const auto n_vertices = in.take<std::uint16_t>();
        const auto residuals = decode_colour(in.take_bytes(in.remaining()), n_vertices);
        ColourState colours({255, 255});
        colours.predict_base(1);
        std::vector<EdgeEnds> ends;
        for (std::int32_t v = 1; v <= n_vertices; ++v) ends.push_back({v - 1, v / 2});
        colours.predict(ends);
        colours.correct(1, ends, [&](std::size_t i, const Rgb8&) { return residuals[i]; });
    } catch (const DecodeError&) {
    }
    return 0;
}
