#include "core/simulation/ring_cameras.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/simulation/hash.h"

namespace anyrate {
namespace {

constexpr double degrees = std::numbers::pi / 180;

/// Rotation of camera k: its rows are the camera's right, down and forward axes in world coordinates.
Mat3 ring_rotation(int k, const RingOptions& options) {
    const auto jitter = [&](std::uint64_t which) {
        return near_normal(hash(options.seed, 16 * static_cast<std::uint64_t>(k) + which));
    };
    const double azimuth = 2 * std::numbers::pi * k / options.n_views + 1.0 * degrees * jitter(0);
    const double elevation = (k % 3 == 2 ? 45 : 20) * degrees + 0.8 * degrees * jitter(1);
    const double roll = 0.8 * degrees * jitter(2);
    const Vec3 forward =
        -Vec3(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    const Vec3 level_right = forward.cross(Vec3::UnitZ()).normalized();
    const Vec3 level_down = forward.cross(level_right);
    Mat3 R;
    R.row(0) = std::cos(roll) * level_right + std::sin(roll) * level_down;
    R.row(1) = std::cos(roll) * level_down - std::sin(roll) * level_right;
    R.row(2) = forward;
    return R;
}

/// Smallest distance from `target` at which a camera turned by R sees all points within `span` (width, height) of focal
/// length 1: |x| <= span/2 (distance + z) for every point (x, y, z) relative to the target in camera axes.
double viewing_distance(std::span<const Vec3> points, const Vec3& target, const Mat3& R, const Vec2& span) {
    double distance = 0;
    for (const Vec3& point : points) {
        const Vec3 p = R * (point - target);
        distance = std::max({distance, 2 * std::abs(p.x()) / span.x() - p.z(), 2 * std::abs(p.y()) / span.y() - p.z()});
    }
    return distance;
}

/// A lens of medium length whose principal point is not quite the image's middle, as with every real camera.
Mat3 ring_calibration(const RingOptions& options) {
    const double focal = 1.7 * options.width;
    const auto offset = [&](std::uint64_t which) {
        return 0.006 * options.width * (2 * unit_interval(hash(options.seed, which)) - 1);
    };
    Mat3 K = Mat3::Identity();
    K(0, 0) = K(1, 1) = focal;
    K(0, 2) = 0.5 * (options.width - 1) + offset(1'000'001);
    K(1, 2) = 0.5 * (options.height - 1) + offset(1'000'002);
    return K;
}

}  // namespace

std::vector<Camera> ring_cameras(std::span<const Vec3> points, const RingOptions& options) {
    Vec3 low = points.front(), high = points.front();
    for (const Vec3& point : points) {
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    const Vec3 target = 0.5 * (low + high);

    const Mat3 K = ring_calibration(options);
    const Vec2 span = options.fill * Vec2(options.width, options.height) / K(0, 0);
    double distance = 0;
    std::vector<Camera> cameras;
    for (int k = 0; k < options.n_views; ++k) {
        const Mat3 R = ring_rotation(k, options);
        distance = std::max(distance, viewing_distance(points, target, R, span));
        cameras.push_back({.K = K, .R = R, .t = Vec3::Zero(), .width = options.width, .height = options.height});
    }
    for (Camera& camera : cameras) camera.t = Vec3(0, 0, distance) - camera.R * target;
    return cameras;
}

}  // namespace anyrate
