#pragma once
#include "core/mesh/mesh.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {

/// A first picture of the object, a moment after its silhouettes are known: the surface of its hull on a coarse grid,
/// cavities covered and parts thinner than about a fortieth of the object swallowed or lost.
/// @return a closed manifold of one piece, some 1,500 vertices, world units
Mesh preview_mesh(const VisualHull& hull);

}  // namespace anyrate
