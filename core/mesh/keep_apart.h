#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Takes back the moves of faces that meet others elsewhere than in what they share, and of those that meet the faces
/// taken back, until all that still meet are where they were.
/// @param before  where the vertices of the mesh were
/// @return the pairs that still meet: they did before, see self_intersections()
std::vector<std::pair<std::int32_t, std::int32_t>> keep_apart(Mesh& mesh, std::span<const Vec3> before);

}  // namespace anyrate
