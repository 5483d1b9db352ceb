#pragma once
#include "core/mesh/mesh.h"
#include "core/simulation/scene_field.h"

namespace anyrate {

struct PolygonizeOptions {
    Vec3 low, high;     ///< box around the solid; the field is positive on its faces and a cell inwards
    double cell = 0.0;  ///< edge of the cubes of the lattice; triangles come out about two thirds as long
};

/// The zero set of a field as a fine mesh: closed and manifold by construction, vertices on the surface, triangles of
/// similar size.
/// Marching tetrahedra on the body-centred cubic lattice, whose tetrahedra are all alike and nearly regular (Chan and
/// Purisima 1998, "A new tetrahedral tesselation scheme for isosurface generation"); then vertices slide towards the
/// middle of their neighbours and are brought back to the field's zero by Newton's method.
Mesh polygonize(const Field& field, const PolygonizeOptions& options);

}  // namespace anyrate
