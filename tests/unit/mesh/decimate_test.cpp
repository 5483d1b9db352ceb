#include "core/mesh/decimate.h"

#include <doctest/doctest.h>

#include "core/error.h"
#include "core/mesh/compare.h"
#include "core/mesh/topology.h"
#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

TEST_CASE("decimate: meets the count, stays closed and near the input") {
    const Mesh fine = torus(2, 0.5, 100, 40);
    const Mesh coarse = decimate(fine, 400);
    const Topology topology = measure_topology(coarse);
    CHECK(topology.n_vertices == 400);
    CHECK(topology.is_closed_manifold());
    CHECK(topology.euler == 0);
    CHECK(compare_surfaces(coarse, fine, {.n_samples = 3000}).mean < 0.003);
}

TEST_CASE("decimate: the vertices left are vertices of the input, far from the origin too") {
    const Mesh fine = shapes::translated(icosphere(3), {4e6, 0, 0});
    const Mesh coarse = decimate(fine, 100);
    CHECK(coarse.n_vertices() == 100);
    for (const Vec3& v : coarse.vertices) CHECK((v - Vec3(4e6, 0, 0)).norm() == doctest::Approx(1).epsilon(1e-6));
}

TEST_CASE("decimate: what is to be kept stays, and all that is left knows where it comes from") {
    const Mesh fine = icosphere(4);
    std::vector<char> is_kept(fine.vertices.size(), 0);
    for (std::size_t v = 0; v < is_kept.size(); ++v) is_kept[v] = fine.vertices[v].x() > 0.8 ? 1 : 0;
    const Decimated coarse = decimate_keeping(fine, 600, is_kept);
    CHECK(coarse.mesh.n_vertices() == 600);
    REQUIRE(coarse.sources.size() == 600);
    std::vector<char> is_left(fine.vertices.size(), 0);
    for (std::size_t v = 0; v < coarse.sources.size(); ++v) {
        const auto source = static_cast<std::size_t>(coarse.sources[v]);
        CHECK((coarse.mesh.vertices[v] - fine.vertices[source]).norm() < 1e-12);
        is_left[source] = 1;
    }
    for (std::size_t v = 0; v < is_kept.size(); ++v) CHECK(is_left[v] >= is_kept[v]);
}

TEST_CASE("decimate: an open mesh is refused") {
    Mesh open = shapes::tetrahedron();
    open.triangles.pop_back();
    CHECK_THROWS_AS(decimate(open, 3), InputError);
}
