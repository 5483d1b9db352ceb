#pragma once
// Depth maps of a wall, as views that look straight at it would have them.
#include <vector>

#include "core/reconstruction/plane_sweep.h"

namespace anyrate {

/// A view from (0, 0, -distance) along +z onto the plane z = 0, 33 x 33 pixels with a focal length of 32, a pixel of
/// disparity being a hundredth of the inverse depth there; known everywhere.
inline DepthMap wall_at_zero(double distance) {
    DepthMap map;
    map.P << 32, 0, 16, 16 * distance, 0, 32, 16, 16 * distance, 0, 0, 1, distance;
    map.step = 0.01 / distance;
    map.inverse_depth = Image<float>(33, 33, static_cast<float>(1 / distance));
    map.agreement = Image<float>(33, 33, 1.0f);
    return map;
}

}  // namespace anyrate
