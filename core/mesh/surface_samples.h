#pragma once
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

struct SurfaceSamples {
    std::vector<Vec3> points;         ///< world units
    std::vector<std::int32_t> faces;  ///< that they lie on
};

/// Random points of the surface, uniform by area. The same seed gives the same points on every machine.
/// @throws InputError if the surface has no area
SurfaceSamples sample_surface(const Mesh& mesh, int n, std::uint64_t seed);

}  // namespace anyrate
