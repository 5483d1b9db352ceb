#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/capture/camera.h"

namespace anyrate {

struct RingOptions {
    int n_views = 22;
    int width = 640, height = 480;
    double fill = 0.9;  ///< part of the image's width and height the object may span
    std::uint64_t seed = 1;
};

/// Cameras on a circle around an object, 20 degrees above its horizon (z is up), every third one at 45 degrees; placed
/// as by hand, a degree or so off. All look at the middle of the object's bounding box from one distance, the smallest
/// from which no view of `points` exceeds `fill`.
std::vector<Camera> ring_cameras(std::span<const Vec3> points, const RingOptions& options);

}  // namespace anyrate
