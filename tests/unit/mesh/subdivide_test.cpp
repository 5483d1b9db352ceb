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

TEST_CASE("subdivide_where: edges between flagged vertices get one more, and the surface stays closed") {
    const Mesh coarse = icosphere(3);
    std::vector<char> flags;
    for (const Vec3& v : coarse.vertices) flags.push_back(v.z() > 0.3);
    const auto is_flagged = [&](std::int32_t v) { return flags[static_cast<std::size_t>(v)] != 0; };
    int n_halves = 0;  // of edges, one for each face beside them
    for (const Triangle& t : coarse.triangles)
        for (std::size_t i = 0; i < 3; ++i) n_halves += is_flagged(t[i]) && is_flagged(t[(i + 1) % 3]);

    const Mesh fine = subdivide_where(coarse, flags);
    const Topology topology = measure_topology(fine);
    CHECK(topology.is_closed_manifold());
    CHECK(topology.euler == 2);
    CHECK(fine.n_vertices() == coarse.n_vertices() + n_halves / 2);
    CHECK(std::equal(coarse.vertices.begin(), coarse.vertices.end(), fine.vertices.begin()));
    for (auto v = static_cast<std::size_t>(coarse.n_vertices()); v < fine.vertices.size(); ++v)
        CHECK(fine.vertices[v].z() > 0.3);
    for (const Triangle& t : coarse.triangles)
        if (std::ranges::count_if(t, is_flagged) < 2) CHECK(std::ranges::count(fine.triangles, t) == 1);
}

TEST_CASE("subdivide_where: all flags are subdivide(), none change nothing") {
    const Mesh coarse = torus(2, 0.5, 12, 8);
    const std::size_t n = coarse.vertices.size();
    const Mesh all = subdivide_where(coarse, std::vector<char>(n, 1)),
               none = subdivide_where(coarse, std::vector<char>(n));
    CHECK(all.vertices == subdivide(coarse).vertices);
    CHECK(all.triangles == subdivide(coarse).triangles);
    CHECK(none.vertices == coarse.vertices);
    CHECK(none.triangles == coarse.triangles);
}
