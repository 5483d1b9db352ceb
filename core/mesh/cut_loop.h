#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// A simple closed loop of halfedges (3f+i, edges.h), each starting where the one before leads to.
using Loop = std::vector<std::int32_t>;

/// Cuts the mesh along the loops and closes both sides of each cut by a fan about its middle; then smooths the caps a
/// little, which draws them apart. Closed manifold in and out; each loop adds 2 to the Euler number.
/// @param twin   twin_halfedges(mesh)
/// @param loops  no two of them share a vertex
Mesh cut_and_cap(const Mesh& mesh, const std::vector<std::int32_t>& twin, std::span<const Loop> loops);

}  // namespace anyrate
