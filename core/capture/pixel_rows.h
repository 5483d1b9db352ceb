#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace anyrate {

/// An image as its file has it, whose channels are grey, or red, green and blue, each with or without alpha behind.
struct PixelRows {
    int width = 0, height = 0;
    int n_channels = 0;         ///< 1: grey; 2: grey, alpha; 3: colour; 4: colour, alpha
    int bytes_per_channel = 1;  ///< 1 or 2, the high one first
    std::vector<std::uint8_t> bytes;

    bool has_alpha() const { return n_channels % 2 == 0; }
    std::size_t bytes_per_pixel() const { return static_cast<std::size_t>(n_channels * bytes_per_channel); }
    std::size_t bytes_per_row() const { return static_cast<std::size_t>(width) * bytes_per_pixel(); }
    std::size_t n_pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

}  // namespace anyrate
