#pragma once
#include "core/types.h"

namespace anyrate {

/// The point of the segment from `a` to `b` that is nearest to `p`.
Vec3 closest_point_on_segment(const Vec3& p, const Vec3& a, const Vec3& b);

/// The point of the triangle that is nearest to `p`; the triangle may be degenerate.
/// Source: Ericson, Real-Time Collision Detection (2005), section 5.1.5: the Voronoi regions of corners, edges, inside.
Vec3 closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace anyrate
