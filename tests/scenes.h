#pragma once
// Inputs of the tests, built in code: small meshes whose every property can be derived, and a small capture.
#include "core/capture/capture.h"
#include "core/mesh/mesh.h"
#include "core/simulation/parametric_meshes.h"  // icosphere(), torus()

namespace anyrate {

/// The cube [-1, 1]^3, every face n x n squares of two triangles: 12 n^2 triangles, 6 n^2 + 2 vertices, area 24,
/// volume 8.
Mesh cube_surface(int n);

/// A textured sphere of radius 1 around the origin, seen from a ring of cameras; image size is `size` x 3/4 `size`.
Capture sphere_capture(int n_views = 12, int size = 160);

}  // namespace anyrate
