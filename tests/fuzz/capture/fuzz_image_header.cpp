// The header of an image: a size that comes back is a size.
#include <cstdint>
#include <cstdlib>

#include "core/capture/image_header.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto header = anyrate::read_image_header({data, size});
    if (header && (header->width <= 0 || header->height <= 0)) std::abort();
    if (anyrate::jpeg_is_complete({data, size}) && size < 4) std::abort();
    return 0;
}
