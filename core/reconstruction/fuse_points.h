#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/visual_hull.h"

namespace anyrate {

/// One even cloud from the overlapping surfaces that several depth maps show: no single map is as smooth as their mean.
/// What only a few pixels bear out is left out.
/// @param pixel    footprint of a depth map's pixel, world units; features of the result are about two pixels large
/// @param spacing  of the points that come out, world units, at most `pixel`
/// @return points whose areas add up to that of the surface
std::vector<OrientedPoint> fuse_points(std::span<const OrientedPoint> points, double pixel, double spacing);

}  // namespace anyrate
