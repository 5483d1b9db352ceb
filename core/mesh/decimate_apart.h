#pragma once
#include "core/mesh/mesh.h"

namespace anyrate {

/// As decimate(), but a surface that does not pass through itself is not made to: quadrics know of the planes around a
/// vertex, not of what lies close by on the other side of a fold or a thin part. Vertices around faces that come to
/// meet are kept instead, with others collapsed for them, up to four times.
/// @throws InputError if `mesh` is not a closed manifold
Mesh decimate_apart(const Mesh& mesh, int n_vertices);

}  // namespace anyrate
