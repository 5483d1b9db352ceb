#pragma once
#include "core/mesh/mesh.h"
#include "core/progressive/grid.h"
#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// The grid of a log: holds the surface with room for vertices that move outward, fine enough for the steps of so many
/// vertices; base positions are as fine as suits a base of the surface's own vertex count, as base_shift() says.
/// @param mesh        the surface, world units, at least one vertex
/// @param n_vertices  of the finest mesh of the log
Grid make_grid(const Mesh& mesh, int n_vertices);

/// How coarse the positions of a base may be, as a power of two of grid units: an edge is 18 to 36 of them long on
/// average. With to_base(), the bust, pot and bowl of the benchmarks are then within 1 % as near the truth at 2,500
/// vertices as if nothing were rounded, for 25 % fewer bytes than vertices rounded to a quarter of that. Another bit
/// less takes another kilobyte off, but adds 3 to 7 % of error.
/// @param base  world units
int base_shift(const Mesh& base, const Grid& grid);

/// The mesh with every vertex at a position that a base may have, near it along the surface rather than nearest:
/// a vertex may slide within its faces, but hardly leave them. No face turns by more than 60 degrees if that can be
/// helped.
/// @param grid  holds the mesh
BaseMesh to_base(const Mesh& mesh, const Grid& grid);

/// The mesh with every vertex at the nearest position that a base may have.
/// @param grid  holds the mesh
BaseMesh nearest_base(const Mesh& mesh, const Grid& grid);

}  // namespace anyrate
