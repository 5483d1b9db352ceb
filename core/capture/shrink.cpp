#include "core/capture/shrink.h"

#include <algorithm>
#include <cassert>
#include <cstdint>

namespace anyrate {
namespace {

/// Where the pixels begin that pixel i of a smaller side stands for.
int begin_of(int i, int smaller, int larger) {
    return static_cast<int>(static_cast<std::int64_t>(i) * larger / smaller);
}

Rgb8 mean(const ColourImage& image, int x_begin, int x_end, int y_begin, int y_end) {
    std::uint64_t r = 0, g = 0, b = 0;
    for (int y = y_begin; y < y_end; ++y) {
        for (int x = x_begin; x < x_end; ++x) {
            const Rgb8& pixel = image(x, y);
            r += pixel.r, g += pixel.g, b += pixel.b;
        }
    }
    const auto n = static_cast<std::uint64_t>(x_end - x_begin) * static_cast<std::uint64_t>(y_end - y_begin);
    const auto rounded = [n](std::uint64_t sum) { return static_cast<std::uint8_t>((sum + n / 2) / n); };
    return {rounded(r), rounded(g), rounded(b)};
}

}  // namespace

ColourImage shrink(const ColourImage& image, int longest) {
    assert(longest >= 1);
    const int longer = std::max(image.width, image.height);
    if (longer <= longest) return image;
    const auto shrunk = [&](int side) { return std::max(begin_of(longest, longer, side), 1); };
    ColourImage small(shrunk(image.width), shrunk(image.height));
    for (int y = 0; y < small.height; ++y) {
        for (int x = 0; x < small.width; ++x) {
            small(x, y) = mean(image, begin_of(x, small.width, image.width), begin_of(x + 1, small.width, image.width),
                               begin_of(y, small.height, image.height), begin_of(y + 1, small.height, image.height));
        }
    }
    return small;
}

}  // namespace anyrate
