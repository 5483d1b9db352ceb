#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/capture/image.h"
#include "core/reconstruction/parallax.h"
#include "core/reconstruction/pixel_box.h"

namespace anyrate {

/// Brightness, 0 to `white`, or `unknown_brightness` where a pixel is not the object's alone.
using BrightnessImage = Image<std::uint16_t>;
inline constexpr std::uint16_t white = 1020;  ///< four times that of a photograph: red + 2 green + blue
inline constexpr std::uint16_t unknown_brightness = std::numeric_limits<std::uint16_t>::max();

/// A view that others are compared with: the four pixels around a place lie in one word, so that to interpolate is to
/// read once.
class PatchImage {
public:
    PatchImage() = default;
    explicit PatchImage(const BrightnessImage& image);

    int width() const { return width_; }
    int height() const { return height_; }
    /// Pixels (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1), 16 bits each from the lowest, is word y (width - 1) + x;
    /// all bits are set where one of the four is unknown. There are none if a side is less than two pixels long.
    std::span<const std::uint64_t> patches() const { return patches_; }

private:
    int width_ = 0, height_ = 0;
    std::vector<std::uint64_t> patches_;
};

/// Compares windows of a reference view with what a plane parallel to its image carries over from another view.
class WindowCorrelation {
public:
    /// @param radius  a window has 2 radius + 1 pixels a side
    WindowCorrelation(const BrightnessImage& reference, int radius);

    /// Floats from a row of a box to the next in what correlate() gives: the width in whole lanes.
    static int pitch_of(const PixelBox& box);

    /// Squared normalised cross-correlation, 0 to 1, of the windows around the pixels of a box (0 if they correlate
    /// negatively), over the pixels that both images know. 0 if they are less than half of the window, or the window's
    /// middle is not among them. Contrast of the size of the images' noise does not count as agreement.
    /// @param other         at least 2 x 2 pixels
    /// @param correlations  gets the box row by row, see pitch_of(); what fills up a row has no meaning
    void correlate(const PatchImage& other, const Parallax& parallax, double inverse_depth, const PixelBox& box,
                   std::vector<float>& correlations);

private:
    void enter_row(const PatchImage& other, const Parallax& parallax, double inverse_depth, const PixelBox& box, int y);
    void correlate_row(const PixelBox& box, int y, float* correlations);

    int radius_;
    // Of the reference, -1 .. 1, and 1 where it is known; with a frame of unknown pixels around it, which are 0.
    Image<float> reference_, known_;
    std::size_t pitch_ = 0;    // columns that the windows of the current box touch, in whole lanes
    std::vector<float> rows_;  // the window's rows of the quantities summed, as a ring
};

}  // namespace anyrate
