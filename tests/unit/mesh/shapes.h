#pragma once
// Surfaces of known size and genus for the tests of this folder.
#include <functional>

#include "core/mesh/mesh.h"

namespace anyrate::shapes {

Mesh tetrahedron();

/// A sphere about the origin: an icosahedron whose faces were divided in four `levels` times.
Mesh sphere(double radius, int levels);

/// A torus around the z axis: `around` times `across` quads, each cut in two.
Mesh torus(double major_radius, double minor_radius, int around, int across);

/// The zero set of a function over [-1, 1]^3 by marching tetrahedra, `n` cells a side: closed and manifold, with the
/// slivers such meshes have. `field` is negative inside and positive on the border.
Mesh zero_set(const std::function<double(const Vec3&)>& field, int n);

/// Both meshes as one, in two pieces.
Mesh together(const Mesh& a, const Mesh& b);

Mesh translated(Mesh mesh, const Vec3& by);

}  // namespace anyrate::shapes
