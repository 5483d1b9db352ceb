#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/plane_sweep.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {

struct CavityOptions {
    double margin_px = 1.5;  ///< of disparity at the sweep's level: closer than this, the hull is right
    int n_views = 3;         ///< that must see through a point of the hull
};

/// No silhouette shows the inside of a bowl: there the visual hull is a lid. Drops the points of the hull that views
/// see through by a clear margin, and puts points of the surface seen behind them in their place. Where the hull is
/// right, its points stay as they are.
/// @param maps  confirmed depth maps (confirm_depths())
/// @return oriented points for Poisson reconstruction, about as dense as the hull's
std::vector<OrientedPoint> open_cavities(const VisualHull& hull, std::span<const DepthMap> maps,
                                         const CavityOptions& options = {});

}  // namespace anyrate
