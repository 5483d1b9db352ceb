#include "core/reconstruction/untangle.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/mesh/self_intersections.h"
#include "core/simulation/parametric_meshes.h"

using namespace anyrate;

namespace {

/// A sphere whose cap is pushed through the other side, `by` radii along the axis.
Mesh pierced_sphere(double by) {
    Mesh mesh = icosphere(4);
    for (Vec3& v : mesh.vertices)
        if (v.normalized().x() > 0.97) v.x() -= by;
    return mesh;
}

}  // namespace

TEST_CASE("Untangle: a surface that does not pass through itself stays, to the last bit") {
    Mesh mesh = icosphere(3);
    CHECK(untangle(mesh));
    CHECK(mesh.vertices == icosphere(3).vertices);
}

TEST_CASE("Untangle: a cap that was pushed through the other side is pulled back, the rest stays") {
    Mesh mesh = pierced_sphere(2.5);
    REQUIRE(!self_intersections(mesh).empty());
    CHECK(untangle(mesh));
    CHECK(self_intersections(mesh).empty());
    std::size_t n_far = 0;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const Vec3 was = icosphere(4).vertices[v];
        CHECK(mesh.vertices[v].norm() < 1.0 + 1e-9);
        // Two rings around the faces that met have moved: those at the dent and those where it came out.
        if (std::abs(was.x()) < 0.8) CHECK(mesh.vertices[v] == was);
        n_far += (mesh.vertices[v] - was).norm() > 0.1 ? 1U : 0U;
    }
    CHECK(n_far < mesh.vertices.size() / 20);
}
