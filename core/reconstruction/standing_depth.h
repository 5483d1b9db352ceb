#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/reconstruction/inverse_depth.h"
#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/pixel_box.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// Inverse depth of the faces of a surface that stand still while others move, kept for as long as they do: in round
/// after round of optimise_surface() no more is drawn than what moved.
class StandingDepth {
public:
    /// Forgets what is not so any more: where another part stands still, or elsewhere, or before other cameras.
    /// @param level   of the pyramid, that depth is rendered at
    /// @param moving  faces, ascending; the vertices of all others stand still
    void keep(const PhotoImages& images, int level, const SurfaceView& surface, std::span<const std::int32_t> moving);

    /// The vertices of the moving faces, ascending.
    std::span<const std::int32_t> moving_vertices() const { return moving_vertices_; }

    /// Standing and moving faces as a view sees them: in the box what render_inverse_depth_in() makes of the whole
    /// surface, to the bit. Two threads must not ask for the same view.
    /// @param image     of `view`, at the level that depth is rendered at
    /// @param box       not empty, within the image
    /// @param vertices  project() of the moving ones
    InverseDepthPart draw(std::size_t view, const PhotoLevel& image, const PixelBox& box,
                          std::span<const ScreenVertex> vertices);

private:
    /// What stands still, as one view sees it.
    struct View {
        Mat34 P = Mat34::Zero();
        PixelBox box;  ///< that is drawn; empty is none
        InverseDepthPart depth;
    };

    bool holds(const PhotoImages& images, int level, const SurfaceView& surface,
               std::span<const std::int32_t> moving) const;

    int level_ = -1;
    std::vector<View> views_;
    std::vector<Vec3> vertices_;
    std::vector<Triangle> triangles_, standing_, moving_;
    std::vector<char> stands_;  ///< one flag a vertex
    std::vector<std::int32_t> moving_faces_, moving_vertices_;
};

}  // namespace anyrate
