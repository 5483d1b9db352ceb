#pragma once
#include <vector>

#include "core/capture/image.h"
#include "core/reconstruction/pixel_box.h"

namespace anyrate {

/// How the pixels of one view move in another as their depth changes: x_other ~ A x + b / depth, both homogeneous,
/// with the depth along the first view's optical axis.
struct Parallax {
    Mat3 A = Mat3::Identity();
    Vec3 b = Vec3::Zero();
};

/// Compares windows of a reference view with what a plane parallel to its image carries over from another view. The
/// price of a window does not depend on its size: sums over its columns are kept from row to row.
class WindowCorrelation {
public:
    /// @param reference  brightness, NaN where a pixel is not the object's
    /// @param radius     a window has 2 radius + 1 pixels a side
    WindowCorrelation(const Image<float>& reference, int radius);

    /// Squared normalised cross-correlation, 0 to 1, of the windows around the pixels of a box (0 if they correlate
    /// negatively), over the pixels that both images know. 0 if they are less than half of the window, or the window's
    /// middle is not among them. Contrast of the size of the images' noise does not count as agreement.
    /// @param other  brightness of the other view, NaN where unknown; at least 2 x 2 pixels
    /// @return an image of the reference's size, set inside the box; valid until the next call
    const Image<float>& correlate(const Image<float>& other, const Parallax& parallax, double inverse_depth,
                                  const PixelBox& box);

private:
    void carry_row(const Image<float>& other, const Parallax& parallax, double inverse_depth, const PixelBox& box,
                   int y);
    void enter_row(const PixelBox& box, int y, std::size_t slot);
    void correlate_row(const PixelBox& box, int y, std::size_t middle_slot);

    int radius_;
    Image<float> reference_;      // with a frame of `radius` unknown pixels around it
    std::size_t pitch_ = 0;       // columns that the windows of the current box touch
    std::vector<float> carried_;  // the other view, along the current row
    std::vector<float> rows_;     // the window's rows of the quantities summed, as a ring
    std::vector<float> columns_;  // sums over those rows
    std::vector<float> window_;   // sums over the whole window
    Image<float> correlation_;
};

}  // namespace anyrate
