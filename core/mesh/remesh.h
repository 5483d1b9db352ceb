#pragma once
#include "core/mesh/mesh.h"

namespace anyrate {

struct RemeshOptions {
    int n_vertices = 2500;  ///< met within 2 %, but for those that detail adds
    int iterations = 10;    ///< rounds of split, collapse, flip, smooth and project
    /// Edges, root mean square: where the input is further off an even mesh, edges become half as long. 0: nowhere.
    double detail = 0;
};

/// An isotropic mesh of the same surface: near-equal edges (of two lengths if detail is asked for), valences near six,
/// closed and manifold like its input, the same genus; every vertex lies on the input surface.
/// Source: Botsch and Kobbelt 2004, "A Remeshing Approach to Multiresolution Modeling".
/// Parts thinner than the edges stay, as far as three vertices around can show them. Colours are dropped.
/// @throws InputError if `mesh` is not a closed manifold, or so few vertices cannot carry its topology
Mesh remesh_isotropic(const Mesh& mesh, const RemeshOptions& options);

}  // namespace anyrate
