#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/capture/image.h"
#include "core/reconstruction/float8.h"
#include "core/reconstruction/inverse_depth.h"
#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/standing_depth.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

struct VisibilityOptions {
    double min_cos = 0.3;       ///< views flatter than this to the face do not count: their footprint is a smear
    double tolerance_px = 1.0;  ///< depth tolerance, in pixels of the depth map times the slope of the face
    /// What stands this much in front of a surface, pixels of the depth map, hides a pixel more around it: behind a
    /// contour that is not yet where it will be, a surface would follow the front's colours. Without it the floor of
    /// the bowl has pits and is 4 % worse; with 8 it is 2 % worse, with 2 or a second pixel around 8 and 15 %.
    double far_px = 4.0;
    /// Of the pyramid, that depth is rendered at. At half the photographs' resolution all errors are 2 to 4 % larger.
    int finest_level = 0;
};

/// One view that sees a face.
struct FaceView {
    std::int32_t view = 0;
    bool whole = false;  ///< no part of the face is hidden; otherwise each sample has to ask look_at()
};

/// The pyramid level that depth is rendered at: `finest_level`, or a coarser one where that has more pixels than depth
/// maps need.
int depth_map_level(const PhotoImages& images, int finest_level);

/// What a surface has, as a part from 0 to 1, of the inverse depth of another that is VisibilityOptions::far_px in
/// front of it.
/// @param level  of the pyramid, that depth is rendered at
float far_part(const PhotoView& view, int level, const VisibilityOptions& options);

/// World size of a pixel of level 0 at a point, from the nearest view.
double pixel_size_at(const PhotoImages& images, const Vec3& point);

/// Which views see which part of a surface, by z-buffer (Nghiem et al., step 2). Depths are in world units and all
/// tolerances relative to the pixel, so that the scale of the world does not matter.
class Visibility {
public:
    /// @param faces  that will be asked for, ascending; empty is all. The others hide what they hide, but views() and
    /// mean_area_px() say nothing of them, and depth is rendered around those asked for alone: up to reach_px from
    /// where a view sees them, look_at() is the same as with all.
    /// @param standing  of the surface before, whose other faces may stand where these do; gets what the next one needs
    Visibility(const PhotoImages& images, const SurfaceView& surface, const VisibilityOptions& options = {},
               std::span<const std::int32_t> faces = {}, StandingDepth* standing = nullptr);

    /// The views that see a face, ascending.
    std::span<const FaceView> views(std::int32_t face) const {
        const auto f = static_cast<std::size_t>(face);
        return {face_views_.data() + begin_[f], begin_[f + 1] - begin_[f]};
    }
    /// Mean of the face's projected area A_i over the views that see it, pixels of level 0 (Nghiem et al., Eq. 7).
    double mean_area_px(std::int32_t face) const { return mean_area_px_[static_cast<std::size_t>(face)]; }
    /// World size of a pixel of level 0 at the face, from the nearest view (seen or not).
    double pixel_size(std::int32_t face) const { return pixel_size_[static_cast<std::size_t>(face)]; }
    /// How far a face may be moved after it was asked for: more than the steps of a round of optimise_surface() take
    /// it.
    static constexpr int reach_px = 8;  ///< pixels of the depth map
    /// Which of eight points of the face, at pixels (x, y) of level 0, are in front of everything else.
    /// @param view           one of views()
    /// @param inverse_depth  1 / world units, along the optical axis
    /// @param visible        1 or 0
    void look_at(std::int32_t face, std::int32_t view, const Float8& x, const Float8& y, const Float8& inverse_depth,
                 Float8& visible) const;

private:
    /// What a view sees of the surface; there is nothing to see around the part that is rendered.
    struct View {
        int width = 0, height = 0;  ///< of the whole depth map
        /// Its pixels are the largest of four (inverse_depth.h); 0 where there is no surface; empty if no face is seen.
        InverseDepthPart depth;
    };

    int level_ = 0;    ///< of the pyramid, at which depth is rendered
    float scale_ = 1;  ///< of its pixels
    std::vector<View> views_;
    std::vector<float> slope_;  ///< per face: depth tolerance as a part of depth, the largest over its views
    std::vector<std::size_t> begin_;
    std::vector<FaceView> face_views_;
    std::vector<double> mean_area_px_, pixel_size_;
};

}  // namespace anyrate
