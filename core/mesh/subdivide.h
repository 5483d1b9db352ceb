#pragma once
#include "core/mesh/mesh.h"

namespace anyrate {

/// Every face becomes four: a new vertex for each edge, at its middle but bulging as the normals of its ends ask. The
/// old vertices keep their numbers and places. Source: the edge points of PN triangles (Vlachos, Peters, Boyd, Mitchell
/// 2001), evaluated at the middle. Closed manifold in and out, colours are dropped.
Mesh subdivide(const Mesh& mesh);

}  // namespace anyrate
