#include "core/mesh/topology.h"

#include <doctest/doctest.h>

#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

TEST_CASE("Topology: a sphere has Euler number 2 and a torus 0") {
    const Topology sphere = measure_topology(icosphere(3));
    CHECK(sphere.is_closed_manifold());
    CHECK(sphere.n_components == 1);
    CHECK(sphere.euler == 2);
    CHECK(sphere.n_edges * 2 == sphere.n_faces * 3);
    const Topology ring = measure_topology(torus(2, 1, 20, 10));
    CHECK(ring.is_closed_manifold());
    CHECK(ring.euler == 0);
}

TEST_CASE("Topology: a double torus by marching tetrahedra has genus 2") {
    // The lemniscate x^2 (1 - x^2) = y^2 thickened.
    const Mesh mesh = shapes::zero_set(
        [](const Vec3& p) {
            const Vec3 q = 1.2 * p;
            const double f = q.x() * q.x() * (1 - q.x() * q.x()) - q.y() * q.y();
            return f * f + q.z() * q.z() - 0.015;
        },
        40);
    const Topology topology = measure_topology(mesh);
    CHECK(topology.is_closed_manifold());
    CHECK(topology.n_components == 1);
    CHECK(topology.euler == -2);
}

TEST_CASE("Topology: every kind of fault is counted") {
    SUBCASE("a missing triangle leaves three boundary edges") {
        Mesh open = icosphere(1);
        open.triangles.pop_back();
        CHECK(measure_topology(open).n_boundary_edges == 3);
    }
    SUBCASE("a turned triangle disagrees along its three edges") {
        Mesh turned = icosphere(1);
        std::swap(turned.triangles[7][0], turned.triangles[7][1]);
        CHECK(measure_topology(turned).n_inconsistent_edges == 3);
    }
    SUBCASE("two tetrahedra that share an edge") {
        Mesh pair = shapes::together(shapes::tetrahedron(), shapes::tetrahedron());
        for (Triangle& t : pair.triangles)
            for (auto& v : t)
                if (v == 4 || v == 5) v -= 4;
        CHECK(measure_topology(pair).n_nonmanifold_edges == 1);
    }
    SUBCASE("two tetrahedra that share a vertex, and the vertex left over") {
        Mesh pair = shapes::together(shapes::tetrahedron(), shapes::tetrahedron());
        for (Triangle& t : pair.triangles)
            for (auto& v : t)
                if (v == 4) v = 0;
        const Topology topology = measure_topology(pair);
        CHECK(topology.n_nonmanifold_edges == 0);
        CHECK(topology.n_nonmanifold_vertices == 2);
        CHECK(topology.n_components == 1);
    }
    SUBCASE("a triangle that names a vertex twice") {
        Mesh degenerate = shapes::tetrahedron();
        degenerate.triangles.push_back({0, 0, 1});
        CHECK_FALSE(measure_topology(degenerate).is_closed_manifold());
    }
    SUBCASE("nothing at all") { CHECK_FALSE(measure_topology(Mesh{}).is_closed_manifold()); }
}

TEST_CASE("largest_component: the piece of largest volume stays, not the one of most triangles") {
    const Mesh small = icosphere(3, 0.1), large = shapes::translated(icosphere(1), {5, 0, 0});
    for (const Mesh& both : {shapes::together(small, large), shapes::together(large, small)}) {
        CHECK(measure_topology(both).n_components == 2);
        const Mesh kept = largest_component(both);
        CHECK(kept.vertices == large.vertices);
        CHECK(kept.triangles == large.triangles);
    }
}

TEST_CASE("largest_component: colours follow their vertices") {
    Mesh small = icosphere(1, 0.1), large = icosphere(1);
    small.colours.assign(small.vertices.size(), Rgb8{1, 2, 3});
    large.colours.assign(large.vertices.size(), Rgb8{4, 5, 6});
    CHECK(largest_component(shapes::together(small, large)).colours == large.colours);
}
