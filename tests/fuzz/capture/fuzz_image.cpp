// The pixels of an image: what comes back has the size that its header tells, and all readers see the same colours.
#include <cstdint>
#include <cstdlib>

#include "core/capture/image_io.h"
#include "core/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::span<const std::uint8_t> bytes(data, size);
    const auto header = anyrate::read_image_header(bytes);
    constexpr std::int64_t most_pixels = 1 << 14;  // the loader's limit stands for this one
    if (!header || std::int64_t{header->width} * header->height > most_pixels) return 0;
    const auto is_whole = [&](const auto& image) {
        return image.width == header->width && image.height == header->height &&
               image.pixels.size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    };
    try {
        const anyrate::CutOut cut_out = anyrate::decode_cut_out(bytes, *header);
        if (!is_whole(cut_out.image) || (cut_out.mask && !is_whole(*cut_out.mask))) std::abort();
        if (anyrate::decode_colour(bytes, *header).pixels != cut_out.image.pixels) std::abort();
        if (!is_whole(anyrate::decode_mask(bytes, *header))) std::abort();
    } catch (const anyrate::InputError&) {
    }
    return 0;
}
