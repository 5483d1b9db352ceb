#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "core/progressive/halfedge_connectivity.h"
#include "tests/golden/sample_models.h"

namespace anyrate {
namespace {

const Grid grid = samples::unit_grid(10);

HalfedgeConnectivity icosphere_connectivity() {
    const BaseMesh base = samples::icosphere(grid, 1);
    return {static_cast<int>(base.positions.size()), base.triangles};
}

}  // namespace

TEST_CASE("HalfedgeConnectivity: a flip replaces an edge by the other diagonal of its two faces") {
    HalfedgeConnectivity mesh = icosphere_connectivity();
    const std::int32_t h = 4, t = mesh.twin(h);
    const std::int32_t p = mesh.origin(h), q = mesh.target(h);
    const std::int32_t m = mesh.origin(HalfedgeConnectivity::prev(h)), s = mesh.origin(HalfedgeConnectivity::prev(t));
    REQUIRE(mesh.can_flip(h));
    const int valence_p = mesh.valence(p), valence_m = mesh.valence(m);
    mesh.flip(h);
    CHECK_FALSE(mesh.are_neighbours(p, q));
    CHECK(mesh.are_neighbours(m, s));
    CHECK(mesh.valence(p) == valence_p - 1);
    CHECK(mesh.valence(m) == valence_m + 1);
}

TEST_CASE("HalfedgeConnectivity: flipping the new diagonal restores the two triangles") {
    HalfedgeConnectivity mesh = icosphere_connectivity();
    const auto sorted_corners = [&](std::int32_t f) {
        Triangle t = mesh.triangles()[static_cast<std::size_t>(f)];
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        return t;
    };
    const std::int32_t h = 4, f = h / 3, g = mesh.twin(h) / 3;
    const Triangle before_f = sorted_corners(f), before_g = sorted_corners(g);
    mesh.flip(h);
    mesh.flip(HalfedgeConnectivity::next(h));  // the new diagonal, seen from the same face
    const bool same = sorted_corners(f) == before_f && sorted_corners(g) == before_g;
    const bool exchanged = sorted_corners(f) == before_g && sorted_corners(g) == before_f;
    CHECK((same || exchanged));
}

TEST_CASE("HalfedgeConnectivity: an edge whose other diagonal exists already is not flipped") {
    // In a tetrahedron every pair of vertices is joined.
    const std::vector<Triangle> triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    const HalfedgeConnectivity mesh(4, triangles);
    for (std::int32_t h = 0; h < 12; ++h) CHECK_FALSE(mesh.can_flip(h));
}

TEST_CASE("HalfedgeConnectivity: rolling back splits and flips leaves the arrays as they were") {
    HalfedgeConnectivity mesh = icosphere_connectivity();
    const HalfedgeConnectivity before = mesh;
    const int V = mesh.n_vertices(), F = mesh.n_faces();
    mesh.split(5, *mesh.split_site(5));
    mesh.split(3, *mesh.split_site(3));
    for (std::int32_t h = 0; h < 30; ++h) {
        if (mesh.can_flip(h)) mesh.flip(h);
    }
    mesh.roll_back(V, F);
    REQUIRE(mesh.n_faces() == before.n_faces());
    CHECK(std::ranges::equal(mesh.triangles(), before.triangles()));
    for (std::int32_t h = 0; h < 3 * F; ++h) CHECK(mesh.twin(h) == before.twin(h));
    for (std::int32_t v = 0; v < V; ++v) {
        CHECK(mesh.outgoing(v) == before.outgoing(v));
        CHECK(mesh.valence(v) == before.valence(v));
    }
}

TEST_CASE("RefinableMesh: a split flips the long diagonals that its obtuse halves leave behind") {
    // Right-angled isosceles triangles: bisecting the neighbours at their short sides leaves angles of 135 degrees.
    RefinableMesh mesh(samples::flat_cube(grid, 2), grid, {});
    const std::int32_t V = mesh.n_vertices();
    mesh.split(17, [](const ScalarSite&) { return 0; });
    bool flipped = false;
    for (std::int32_t v = V; v < V + 3; ++v) flipped |= mesh.valence(v) != 5;
    CHECK(flipped);
}

}  // namespace anyrate
