#pragma once
#include <vector>

#include "core/capture/capture.h"

namespace anyrate {

struct HullOptions {
    double pixels_per_cell = 1.5;  ///< finest cell, in pixels of the views that see it
    int max_depth = 9;             ///< of the octree: at most 2^max_depth cells an axis
};

/// A point of a surface with its outward unit normal, world units.
struct OrientedPoint {
    Vec3 position, normal;
};

/// The visual hull's boundary as an even cloud of oriented points, placed on the silhouette cones to a fraction of a
/// cell; thin parts down to about one pixel survive.
struct VisualHull {
    Vec3 lower, upper;    ///< tight bounding box of the hull, world units
    double cell = 0;      ///< edge of the finest cell, world units
    std::vector<OrientedPoint> points;
};

/// Intersects the silhouette cones of all views on an octree. A view whose image does not contain a point says nothing
/// about it, so cameras may see only a part.
/// Source: Nghiem et al., step 1; Laurentini 1994.
/// @throws InputError if no point of space is inside every silhouette
VisualHull visual_hull(const Capture& capture, const HullOptions& options = {});

}  // namespace anyrate
