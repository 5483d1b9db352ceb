#pragma once
#include "core/mesh/mesh.h"
#include "core/reconstruction/poisson.h"

namespace anyrate {

/// The zero set of the field as a triangle mesh, closed and manifold by construction (the field must be positive on the
/// grid's border), outward where the field is positive.
Mesh iso_surface(const ScalarField& field);

}  // namespace anyrate
