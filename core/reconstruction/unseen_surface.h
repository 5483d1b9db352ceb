#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/surface_view.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {

struct UnseenOptions {
    double least_cos = 0.1;     ///< between normal and direction to a view: flatter, a view sees as good as nothing
    int n_views = 2;            ///< that must contain a point and look at it from the front
    double least_share = 0.02;  ///< of the surface's area: what surrounds a smaller part says well enough where it is
};

/// Large parts of a visual hull that face away from nearly all views or lie beyond their images, such as the cone that
/// it has below whatever stands on a table: the silhouettes' rays have only passed by, so all that the hull says is
/// that nothing is outside of it. What hides a point from a view is not looked at.
/// @return one flag a vertex: 1 where fewer views look at the front of the surface
std::vector<char> unseen_vertices(const SurfaceView& surface, const PhotoImages& images,
                                  const UnseenOptions& options = {});

/// The points that enough views look at.
std::vector<OrientedPoint> without_unseen(std::span<const OrientedPoint> points, const PhotoImages& images,
                                          const UnseenOptions& options = {});

}  // namespace anyrate
