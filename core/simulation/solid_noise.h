#pragma once
#include <array>
#include <cstdint>

#include "core/types.h"

namespace anyrate {

/// Smooth random functions of a point in space, to paint solids with.
/// Gradient noise on the integer lattice with a fade that is twice continuously differentiable, so that no lattice
/// plane shows as a crease. Source: Perlin 2002, "Improving Noise" (here with 256 random unit gradients instead of 12).
class SolidNoise {
public:
    explicit SolidNoise(std::uint64_t seed);

    /// Zero at the lattice points, mean 0, within [-1.5, 1.5] and rarely beyond 1; features about one unit wide.
    double operator()(const Vec3& point) const;

    /// Fractal sum: each octave is twice as fine, `gain` times as strong and rotated, so that the lattices do not
    /// align. Scaled to the strength of one octave.
    double fbm(const Vec3& point, int octaves, double gain = 0.6) const;

private:
    double at(double x, double y, double z) const;
    double corner(int x, int y, int z, double dx, double dy, double dz) const;

    std::array<std::uint8_t, 512> permutation_;  // of 0..255, written twice so that a sum of two needs no wrap
    std::array<std::array<double, 3>, 256> gradients_;
};

}  // namespace anyrate
