#pragma once
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Tells non-separating loops from separating ones: for each halfedge (3f+i, edges.h) up to 64 bits, bit i being set if
/// the edge crosses the i-th loop of a basis of the surface's homology over Z/2. The sum (exclusive or) of the bits
/// along a closed loop is zero if it separates the surface. With genus up to 32 the reverse holds too; beyond that only
/// the first 64 loops of the basis (2 a handle) are looked at. Source: Erickson and Whittlesey 2005, "Greedy optimal
/// homotopy and homology generators"; the basis is Eppstein's tree-cotree decomposition (2003), "Dynamic generators of
/// topologically embedded graphs".
/// @param mesh  closed and manifold
/// @param twin  twin_halfedges(mesh)
std::vector<std::uint64_t> homology_signatures(const Mesh& mesh, const std::vector<std::int32_t>& twin);

}  // namespace anyrate
