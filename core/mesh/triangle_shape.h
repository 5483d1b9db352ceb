#pragma once
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/types.h"

namespace anyrate {

/// The triangle's normal, as long as twice its area.
inline Vec3 twice_area_vector(const Vec3& a, const Vec3& b, const Vec3& c) { return (b - a).cross(c - a); }

/// 4 sqrt(3) area / (sum of squared edge lengths): 1 for the equilateral triangle, 0 for one without area.
/// Source: Bank and Smith 1997, "Mesh smoothing using a posteriori error estimates", Eq. 4.3.
inline double triangle_quality(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double sum = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
    return sum > 0 ? 2 * std::numbers::sqrt3 * twice_area_vector(a, b, c).norm() / sum : 0;
}

}  // namespace anyrate
