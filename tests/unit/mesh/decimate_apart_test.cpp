#include "core/mesh/decimate_apart.h"

#include <doctest/doctest.h>

#include "core/error.h"
#include "core/mesh/decimate.h"
#include "core/mesh/self_intersections.h"
#include "core/mesh/topology.h"
#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

namespace {

/// A sphere of radius 1, and a smaller one within it that is `gap` from it at (1, 0, 0).
Mesh nested_spheres(double gap) { return shapes::together(icosphere(4), icosphere(4, 0.8, {0.2 - gap, 0, 0})); }

}  // namespace

TEST_CASE("Decimate apart: spheres that all but touch do not come to meet") {
    const Mesh spheres = nested_spheres(0.004);
    REQUIRE(self_intersections(spheres).empty());
    REQUIRE(!self_intersections(decimate(spheres, 800)).empty());
    const Mesh coarse = decimate_apart(spheres, 800);
    CHECK(self_intersections(coarse).empty());
    CHECK(coarse.n_vertices() == 800);
    CHECK(measure_topology(coarse).is_closed_manifold());
    CHECK(measure_topology(coarse).n_components == 2);
}

TEST_CASE("Decimate apart: where nothing comes to meet, or all met before, it is what quadrics make") {
    const auto is_as_decimated = [](const Mesh& mesh) {
        const Mesh apart = decimate_apart(mesh, 400), decimated = decimate(mesh, 400);
        return apart.vertices == decimated.vertices && apart.triangles == decimated.triangles;
    };
    CHECK(is_as_decimated(torus(2, 0.5, 100, 40)));
    CHECK(is_as_decimated(nested_spheres(-0.1)));
}

TEST_CASE("Decimate apart: an open mesh is refused") {
    Mesh open = shapes::tetrahedron();
    open.triangles.pop_back();
    CHECK_THROWS_AS(decimate_apart(open, 3), InputError);
}
