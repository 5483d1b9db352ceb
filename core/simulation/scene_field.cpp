#include "core/simulation/scene_field.h"

namespace anyrate {

double dish_field(const Vec3& point) {
    const double r = length(point.x(), point.y());
    const double angle = std::atan2(point.y(), point.x());
    const double z = point.z();
    // Two ellipsoids around the middle of the rim's plane, cut off at the rim.
    const double flute = 0.022 * std::cos(20 * angle) * window(-0.38, 0.24, 0.12, z);
    const double rim = 0.34 + 0.025 * std::cos(10 * angle);
    const double outside = length(r, 1.15 * (z - 0.34)) - 0.97 - flute;
    const double inside = length(r, 1.2 * (z - 0.34)) - 0.84;
    const double shell = smooth_max(smooth_max(outside, z - rim, 0.04), -inside, 0.04);
    const double foot = smooth_max(r - 0.46, std::abs(z + 0.50) - 0.09, 0.04);
    return smooth_min(shell, foot, 0.06);
}

}  // namespace anyrate
