#pragma once
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// The outward unit normal of every vertex: the mean of its faces' normals, weighted by area. No unit vector where the
/// faces have no area or cancel out, or their area is beyond the numbers that a double holds.
std::vector<Vec3> vertex_normals(const Mesh& mesh);

/// The same for mesh files, which know unit normals only: (0, 0, 1) stands for what is none.
std::vector<Eigen::Vector3f> file_normals(const Mesh& mesh);

}  // namespace anyrate
