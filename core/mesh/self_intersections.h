#pragma once
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// The pairs of faces that meet elsewhere than in the vertices and edges they share, the smaller number first, in
/// ascending order: faces that pierce or touch each other, and neighbours folded flat onto each other. Any triangles
/// will do. Faces without area are left out.
///
/// Decided exactly for the mesh on a grid of 2^26 steps along its largest extent, to which the vertices are rounded
/// (the logs' own grids have 2^14 or 2^16): what is nearer than that counts as touching.
std::vector<std::pair<std::int32_t, std::int32_t>> self_intersections(const Mesh& mesh);

}  // namespace anyrate
