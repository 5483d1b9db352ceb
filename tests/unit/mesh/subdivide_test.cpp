#include "core/mesh/subdivide.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/mesh/topology.h"
#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

TEST_CASE("subdivide: a vertex for every edge, four faces for each, the same surface") {
    const Mesh coarse = torus(2, 0.5, 30, 12);
    const Mesh fine = subdivide(coarse);
    const Topology before = measure_topology(coarse), after = measure_topology(fine);
    CHECK(after.is_closed_manifold());
    CHECK(after.euler == before.euler);
    CHECK(fine.n_faces() == 4 * coarse.n_faces());
    CHECK(fine.n_vertices() == coarse.n_vertices() + coarse.n_faces() * 3 / 2);
    CHECK(std::equal(coarse.vertices.begin(), coarse.vertices.end(), fine.vertices.begin()));
}

TEST_CASE(
    "subdivide: the new vertices of a sphere lie nearer to it than the middles of its edges, by a factor of four") {
    const Mesh coarse = icosphere(2);
    double off_middle = 0, off_new = 0;
    for (const Triangle& t : coarse.triangles) {
        const Vec3 &a = coarse.vertices[static_cast<std::size_t>(t[0])],
                   &b = coarse.vertices[static_cast<std::size_t>(t[1])];
        off_middle = std::max(off_middle, 1 - (0.5 * (a + b)).norm());
    }
    for (const Vec3& v : subdivide(coarse).vertices) off_new = std::max(off_new, std::abs(v.norm() - 1));
    CHECK(off_new < 0.25 * off_middle);
}
