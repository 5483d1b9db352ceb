#pragma once
#include <vector>

#include "core/capture/capture.h"

namespace anyrate {

struct HullOptions {
    double pixels_per_cell = 2.0;  ///< edge of the finest cell, in pixels of the views that see it
    int max_depth = 9;             ///< of the octree: at most 2^max_depth cells an axis
};

/// A point of a surface with its outward unit normal, world units.
struct OrientedPoint {
    Vec3 position, normal;
    double area = 0;  ///< of the surface it stands for, world units squared: a sum over points is an integral
};

/// The visual hull's boundary as an even cloud of oriented points, placed on the silhouette cones to a fraction of a
/// cell; thin parts down to about one pixel survive, somewhat thickened.
struct VisualHull {
    Vec3 lower, upper;  ///< tight bounding box of the hull, world units
    double cell = 0;    ///< edge of the finest cell, world units
    std::vector<OrientedPoint> points;
};

/// Intersects the silhouette cones of all views on an octree. Cameras may see only a part: a view whose mask runs into
/// the image's frame says nothing about what the image does not contain. One whose mask keeps clear of it shows the
/// whole object, so beyond its image there is none. Source: Nghiem et al., step 1; Laurentini 1994.
/// @throws InputError if no point of space is inside every silhouette
VisualHull visual_hull(const Capture& capture, const HullOptions& options = {});

}  // namespace anyrate
