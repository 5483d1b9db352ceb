#pragma once
#include <cstdint>
#include <optional>

#include "core/capture/capture.h"
#include "core/reconstruction/pixel_box.h"

namespace anyrate {

/// What a view's mask shows in the whole footprint of a cube of space.
enum class Cover {
    unseen,      ///< the view says nothing about any point of the cube
    background,  ///< no point of the cube projects onto the object
    object,      ///< the image contains the cube, and all of it lies on the object
    mixed,       ///< none of these for certain
};

/// The mask of one view as a smooth outline that the visual hull can be cut along.
///
/// Two repairs come first, both of the size of the segmentation's own errors: gaps in the object of one or two pixels
/// are closed (a wrong column of pixels must not cut it in two), and parts up to four pixels wide grow by a pixel on
/// either side, those of a single pixel by two (so that a grid of two-pixel cells holds them). The outline is the zero
/// set of a signed distance, interpolated between pixel centres and smoothed, but never so far that the sign at a
/// pixel's centre changes.
///
/// A view is complete if its mask keeps clear of the image's frame: then it shows the whole object, and what its image
/// does not contain is background. Of an incomplete view the object may leave the image, and it says nothing about what
/// is there.
class SilhouetteCone {
public:
    explicit SilhouetteCone(const View& view);

    /// Conservative, and consistent with distance(): all of `background` has a positive distance, all of `object` a
    /// negative one. World units.
    Cover cover(const Vec3& centre, double half_edge) const;

    /// Distance of a world point to the silhouette cone, negative inside; approximately Euclidean near the cone, cut
    /// off some pixels away from it. World units. Nothing if an incomplete view's image does not contain the point.
    std::optional<double> distance(const Vec3& point) const;

    /// Edge of a pixel at the point's depth (zero or negative behind the camera), world units.
    double pixel_size(const Vec3& point) const;

    /// Direction, in the world, from the camera's centre through the middle of the mask; nothing if the mask is empty.
    const std::optional<Vec3>& axis() const { return axis_; }
    const Vec3& camera_centre() const { return centre_; }
    bool is_complete() const { return complete_; }

private:
    void count_pixels(const MaskImage& mask, const Mat3& world_from_pixel);
    /// How many of the pixels (x0, y0) .. (x1, y1) are the object's.
    std::int64_t object_pixels(int x0, int y0, int x1, int y1) const;

    /// Where the image ends, half a pixel beyond the centres of its outermost pixels.
    struct Frame {
        double left, top, right, bottom;
    };
    Frame frame_in_pixels() const { return {frame_.x0 - 0.5, frame_.y0 - 0.5, frame_.x1 - 0.5, frame_.y1 - 0.5}; }

    // Only the object and a margin are kept of the image; pixels count from the corner of that part.
    PixelBox frame_;  // the whole image
    Mat34 P_;
    Vec3 centre_;
    double pixels_per_radian_;
    Image<float> distance_px_;  // at pixel centres, negative on the object
    Image<std::uint32_t> sum_;  // object pixels above and to the left, one row and column larger than the part
    bool complete_ = false;
    std::optional<Vec3> axis_;
};

}  // namespace anyrate
