#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Simplifies by collapsing the edges of least quadric error until `n_vertices` are left: the yardstick that
/// progressive models are measured by. Closed manifold in and out, colours are dropped. A few vertices more are left
/// where no further collapse keeps the manifold. Source: Garland and Heckbert 1997, "Surface simplification using
/// quadric error metrics", in OpenMesh's version, which keeps one of the edge's ends.
/// @throws InputError if `mesh` is not a closed manifold
Mesh decimate(const Mesh& mesh, int n_vertices);

/// A simplified mesh that knows where its vertices come from.
struct Decimated {
    Mesh mesh;
    std::vector<std::int32_t> sources;  ///< of each vertex: the one of the input that it is
};

/// The same, but some vertices stay.
/// @param is_kept  one flag a vertex; empty: none
Decimated decimate_keeping(const Mesh& mesh, int n_vertices, std::span<const char> is_kept);

}  // namespace anyrate
