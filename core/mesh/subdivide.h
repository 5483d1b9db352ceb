#pragma once
#include <span>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Every face becomes four: a new vertex for each edge, at its middle but bulging as the normals of its ends ask. The
/// old vertices keep their numbers and places. Source: the edge points of PN triangles (Vlachos, Peters, Boyd, Mitchell
/// 2001), evaluated at the middle. Closed manifold in and out, colours are dropped.
Mesh subdivide(const Mesh& mesh);

/// As subdivide(), but only edges between two flagged vertices get a new one: a face between three of them becomes
/// four, a face with one such edge two.
/// @param flags  one a vertex
Mesh subdivide_where(const Mesh& mesh, std::span<const char> flags);

}  // namespace anyrate
