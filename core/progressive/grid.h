#pragma once
#include <cstdint>

#include "core/types.h"

namespace anyrate {

/// A position in whole grid units.
struct GridPoint {
    std::int32_t x = 0, y = 0, z = 0;
    friend bool operator==(const GridPoint&, const GridPoint&) = default;
};

/// The integer grid on which both ends of the stream compute: world = origin + unit * integer, integers in [0, 2^bits).
struct Grid {
    Vec3 origin = Vec3::Zero();
    double unit = 1.0;  ///< world units of one grid step
    int bits = 14;
    int base_shift = 2;  ///< base positions are multiples of 2^base_shift

    Vec3 to_world(const GridPoint& p) const { return origin + unit * Vec3(p.x, p.y, p.z); }
    friend bool operator==(const Grid&, const Grid&) = default;
};

}  // namespace anyrate
