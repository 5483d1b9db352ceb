#pragma once
// Surfaces of known size and genus for the tests of this folder.
#include <functional>

#include "core/mesh/mesh.h"

namespace anyrate::shapes {

Mesh tetrahedron();

/// The zero set of a function over [-1, 1]^3 by marching tetrahedra, `n` cells a side: closed and manifold, with the
/// slivers such meshes have. `field` is negative inside and positive on the border.
Mesh zero_set(const std::function<double(const Vec3&)>& field, int n);

/// Both meshes as one, in two pieces.
Mesh together(const Mesh& a, const Mesh& b);

Mesh translated(Mesh mesh, const Vec3& by);

}  // namespace anyrate::shapes
