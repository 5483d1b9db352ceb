#pragma once
#include "core/mesh/mesh.h"
#include "core/progressive/grid.h"
#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// The grid of a log: holds the surface with room for vertices that move outward, fine enough for the steps of so many
/// vertices; base positions take 12 bits.
/// @param mesh        the surface, world units, at least one vertex
/// @param n_vertices  of the finest mesh of the log
Grid make_grid(const Mesh& mesh, int n_vertices);

/// The mesh with every vertex at the nearest position that a base may have.
/// @param grid  holds the mesh
BaseMesh to_base(const Mesh& mesh, const Grid& grid);

}  // namespace anyrate
