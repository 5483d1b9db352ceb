#pragma once
// The small types every part shares. World coordinates are right-handed, in the capture's own unit.
#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace anyrate {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Mat34 = Eigen::Matrix<double, 3, 4>;

/// Three vertex numbers, counter-clockwise seen from outside the surface.
using Triangle = std::array<std::int32_t, 3>;

/// A colour as the photographs hold it: sRGB, 8 bits a channel.
struct Rgb8 {
    std::uint8_t r = 0, g = 0, b = 0;
    friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

}  // namespace anyrate
