#pragma once
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// The outward unit normal of every vertex: the mean of its faces' normals, weighted by area. Zero where the faces
/// have no area or cancel out.
std::vector<Vec3> vertex_normals(const Mesh& mesh);

}  // namespace anyrate
