#pragma once
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/types.h"

namespace anyrate {

/// An implicit solid: negative inside, positive outside, its surface the zero set; near the surface about as steep as a
/// distance.
using Field = std::function<double(const Vec3&)>;

/// Union of two solids with a fillet about `radius` wide (a quadratic blend, continuously differentiable).
inline double smooth_min(double a, double b, double radius) {
    const double overlap = std::max(radius - std::abs(a - b), 0.0);
    return std::min(a, b) - overlap * overlap / (4 * radius);
}
/// Intersection of two solids, its edges rounded likewise.
inline double smooth_max(double a, double b, double radius) { return -smooth_min(-a, -b, radius); }

/// Length of a vector in the plane. Not std::hypot, whose care for overflow takes a fifth of the rendering time.
inline double length(double x, double y) { return std::sqrt(x * x + y * y); }

/// 0 below `low`, 1 above `high`, a cubic between.
inline double smooth_step(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}
/// 1 inside (low, high), 0 outside, with soft ends `width` wide that lie within the interval.
inline double window(double low, double high, double width, double x) {
    return smooth_step(low, low + width, x) * (1 - smooth_step(high - width, high, x));
}

/// A deep dish with a fluted outside, a scalloped rim and a foot: one open cavity, genus 0. Radius about 1, z up,
/// within [-1.1, 1.1]^2 x [-0.65, 0.65].
double dish_field(const Vec3& point);

}  // namespace anyrate
