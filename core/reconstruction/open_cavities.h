#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/plane_sweep.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {

struct CavityOptions {
    double margin_px = 1.0;  ///< of disparity at the sweep's level: closer than this, the hull is right
    int n_views = 3;         ///< that must see through a point of the hull
    int n_views_free = 2;    ///< that must see through a place for it to count as outside
};

/// What is known of a surface before it is reconstructed.
struct SurfaceEvidence {
    std::vector<OrientedPoint> points;  ///< on it
    std::vector<Vec3> outside;          ///< places that the object is known not to fill
};

/// No silhouette shows the inside of a bowl: there the visual hull is a lid. Drops the points of the hull that views
/// see through by a clear margin, puts points of the surface seen behind them in their place, and tells which part of
/// the hull's space was seen through: what closes the surface where no view reaches (the belly of a narrow-necked pot)
/// must not run there. Where the hull is right, its points stay as they are.
/// @param maps  confirmed depth maps (confirm_depths())
/// @return points about as dense as the hull's
SurfaceEvidence open_cavities(const VisualHull& hull, std::span<const DepthMap> maps,
                              const CavityOptions& options = {});

}  // namespace anyrate
