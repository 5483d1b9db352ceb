#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/plane_sweep.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {

struct SeenThroughOptions {
    double margin_px = 1.0;  ///< of disparity at the sweep's level: closer than this, the hull is right; 3: lids
                             ///< stay that are a few pixels off, such as over the fold behind a bust's ear
    int n_views = 3;         ///< that must see through a point
};

/// No silhouette shows the inside of a bowl: there the visual hull is a lid. Leaves out the hull's points that views
/// see through by a clear margin.
/// @param maps  confirmed depth maps (confirm_depths())
std::vector<OrientedPoint> without_seen_through(std::span<const OrientedPoint> points, std::span<const DepthMap> maps,
                                                const SeenThroughOptions& options = {});

}  // namespace anyrate
