#pragma once
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Random points of the surface, uniform by area. The same seed gives the same points on every machine.
/// @throws InputError if the surface has no area
std::vector<Vec3> sample_surface(const Mesh& mesh, int n, std::uint64_t seed);

}  // namespace anyrate
