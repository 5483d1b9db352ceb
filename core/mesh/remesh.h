#pragma once
#include "core/mesh/mesh.h"

namespace anyrate {

struct RemeshOptions {
    int n_vertices = 2500;  ///< met within 2 %
    int iterations = 10;    ///< rounds of split, collapse, flip, smooth and project
};

/// An isotropic mesh of the same surface: near-equal edges, valences near six, closed and manifold like its input, the
/// same genus; every vertex lies on the input surface.
/// Source: Botsch and Kobbelt 2004, "A Remeshing Approach to Multiresolution Modeling".
/// Parts thinner than the edges stay, as far as three vertices around can show them. Colours are dropped.
/// @throws InputError if `mesh` is not a closed manifold, or so few vertices cannot carry its topology
Mesh remesh_isotropic(const Mesh& mesh, const RemeshOptions& options);

}  // namespace anyrate
