#pragma once
#include "core/types.h"

namespace anyrate {

/// The point of the segment from `a` to `b` that is nearest to `p`.
Vec3 closest_point_on_segment(const Vec3& p, const Vec3& a, const Vec3& b);

/// The point of the triangle that is nearest to `p`; the triangle may be degenerate.
/// Source: Ericson, Real-Time Collision Detection (2005), section 5.1.5: the Voronoi regions of corners, edges, inside.
Vec3 closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// The weights, which add up to 1, by which the corners make up `p`, a point in the plane of the triangle; a third each
/// if the triangle is degenerate.
Vec3 barycentric(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace anyrate
