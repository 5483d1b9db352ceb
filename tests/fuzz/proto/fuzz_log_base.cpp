// Two u16 (vertices, faces), then any bytes as a base payload; what is accepted must be a mesh that can be refined.
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/error.h"
#include "proto/base_codec.h"
#include "proto/bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace anyrate;
    try {
        ByteReader in(std::as_bytes(std::span(data, size)), "input");
        Header header;
        header.grid.bits = 10;
        header.n_base_vertices = in.take<std::uint16_t>();
        header.n_base_faces = in.take<std::uint16_t>();
        RefinableMesh mesh(decode_base(in.take_bytes(in.remaining()), header), header.grid, header.rules);
        for (std::int32_t face = 0; face < 20; ++face) {
            if (mesh.split_site(face)) mesh.split(face, [](const ScalarSite& site) { return 3 - site.slot; });
        }
    } catch (const DecodeError&) {
    }
    return 0;
}
