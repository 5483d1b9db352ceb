#include "core/mesh/surface.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

TEST_CASE("Surface: which edges may be collapsed is what OpenMesh says of them") {
    for (const Mesh& mesh : {torus(2, 0.5, 12, 3), shapes::tetrahedron(), icosphere(1)}) {
        Surface surface = to_surface(mesh);
        for (const auto h : surface.halfedges())
            CHECK(surface.is_collapse_ok(h) ==
                  surface.OpenMesh::TriMesh_ArrayKernelT<SurfaceTraits>::is_collapse_ok(h));
    }
}

TEST_CASE("Surface: an edge of three around a tube without a face between them stays") {
    Surface tube = to_surface(torus(2, 0.5, 12, 3));
    const auto n_free = std::ranges::count_if(tube.halfedges(), [&](const auto& h) { return tube.is_collapse_ok(h); });
    const auto n_halfedges = static_cast<std::ptrdiff_t>(tube.n_halfedges());
    CHECK(n_free > 0);
    CHECK(n_free <= n_halfedges - 2 * 12 * 3);
}
