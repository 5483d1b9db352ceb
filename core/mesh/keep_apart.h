#pragma once
#include <span>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Takes back the moves of faces that come to meet others elsewhere than in what they share (self_intersections()), and
/// then of those that meet what was taken back, until no faces meet but those that met before.
/// @param before  where the vertices of the mesh were, one a vertex
void keep_apart(Mesh& mesh, std::span<const Vec3> before);

}  // namespace anyrate
