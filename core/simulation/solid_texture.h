#pragma once
#include <cstdint>
#include <functional>

#include "core/simulation/solid_noise.h"
#include "core/types.h"

namespace anyrate {

/// Linear-light albedo in [0, 1] of a point of a solid, in the solid's own coordinates: a size of about one around the
/// origin.
using SolidTexture = std::function<Vec3(const Vec3&)>;

/// The fine structure of a fired and aged surface: clouds, grain down to about 1/200 of the size, hairline cracks and
/// dark specks. What a photograph of a real thing has everywhere, and what matching views live on.
class Patina {
public:
    explicit Patina(std::uint64_t seed) : noise_(seed) {}
    /// A factor around 1 to multiply an albedo by.
    double operator()(const Vec3& point) const;

private:
    SolidNoise noise_;
};

/// A coloured stone with veins, under a patina: for any shape.
SolidTexture veined_stone(std::uint64_t seed);

/// A colour from a ramp of evenly spaced stops; t is clamped to [0, 1].
Vec3 ramp(std::initializer_list<Vec3> stops, double t);

inline Vec3 blend(const Vec3& under, const Vec3& over, double coverage) { return under + coverage * (over - under); }

}  // namespace anyrate
