#pragma once
#include <cstdint>

#include "core/progressive/grid.h"

namespace anyrate {

/// The quantiser step of a face's scalars: the power of two of grid units nearest, in proportion, to its
/// root-mean-square edge length / `step_ratio`, and at least 1. Only integers are compared (proto/FORMAT.md, "Step"):
/// logarithms need not agree between two machines.
inline std::int32_t scalar_step(const GridPoint& a, const GridPoint& b, const GridPoint& c, int step_ratio) {
    const auto squared_length = [](const GridPoint& p, const GridPoint& q) {
        const std::int64_t x = q.x - p.x, y = q.y - p.y, z = q.z - p.z;
        return x * x + y * y + z * z;
    };
    const std::int64_t sum = squared_length(a, b) + squared_length(b, c) + squared_length(c, a);
    // 2^(k - 1/2) <= sqrt(sum / 3) / n < 2^(k + 1/2), squared and without the fraction.
    std::int32_t step = 1;
    for (std::int64_t limit = 6 * std::int64_t{step_ratio} * step_ratio; sum >= limit; limit *= 4) step *= 2;
    return step;
}

}  // namespace anyrate
