#pragma once
#include <cassert>
#include <cstddef>
#include <vector>

#include "core/types.h"

namespace anyrate {

/// A plain row-major image: pixel (x, y) is pixels[y * width + x]. What core algorithms see of a photograph.
template <class Pixel>
struct Image {
    int width = 0, height = 0;
    std::vector<Pixel> pixels;

    Image() = default;
    Image(int w, int h, Pixel fill = {})
        : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), fill) {}

    bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
    Pixel& operator()(int x, int y) { return pixels[index(x, y)]; }
    const Pixel& operator()(int x, int y) const { return pixels[index(x, y)]; }

private:
    std::size_t index(int x, int y) const {
        assert(contains(x, y));
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

using ColourImage = Image<Rgb8>;
using MaskImage = Image<std::uint8_t>;  ///< 0 is background, everything else is the object

}  // namespace anyrate
