#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <set>

#include "core/error.h"
#include "tests/golden/sample_models.h"
#include "tests/unit/progressive/closed_manifold.h"

namespace anyrate {
namespace {

const auto no_move = [](const ScalarSite&) { return 0; };

/// Splits random faces with random scalars, checking the mesh after every one.
void split_at_random(RefinableMesh& mesh, int n_splits, std::uint32_t seed, int largest_scalar) {
    std::mt19937 random(seed);
    const auto below = [&](int n) { return static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(n)); };
    const int euler = testing::euler_characteristic(mesh);
    for (int k = 0; k < n_splits; ++k) {
        const std::int32_t face = below(mesh.n_faces());
        if (!mesh.split_site(face)) continue;
        const int n_vertices = mesh.n_vertices(), n_faces = mesh.n_faces();
        mesh.split(face, [&](const ScalarSite&) { return below(2 * largest_scalar + 1) - largest_scalar; });
        INFO("seed " << seed << ", split " << k << " of face " << face);
        REQUIRE(mesh.n_vertices() == n_vertices + 3);
        REQUIRE(mesh.n_faces() == n_faces + 6);
        REQUIRE(testing::fault_of(mesh) == "");
        REQUIRE(testing::euler_characteristic(mesh) == euler);
    }
}

}  // namespace

TEST_CASE("RefinableMesh: the mesh is a closed manifold of constant genus after each of thousands of random splits") {
    const Grid grid = samples::unit_grid(10);
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        // Scalars up to 40 steps, half an edge: folds and spikes that no encoder would choose.
        RefinableMesh octahedron(samples::octahedron(grid), grid, {});
        split_at_random(octahedron, 60, seed, 40);
        RefinableMesh torus(samples::square_torus(grid), grid, {});
        split_at_random(torus, 40, seed, 10);
    }
}

TEST_CASE(
    "RefinableMesh: on a tiny grid, where vertices coincide and triangles have no area, the mesh stays a manifold") {
    const Grid grid = samples::unit_grid(5);
    for (std::uint32_t seed = 0; seed < 10; ++seed) {
        RefinableMesh mesh(samples::octahedron(grid), grid, {});
        split_at_random(mesh, 60, seed, 3);
    }
}

TEST_CASE("RefinableMesh: a split numbers its vertices and faces as the format says") {
    const Grid grid = samples::unit_grid(10);
    RefinableMesh mesh(samples::icosphere(grid, 1), grid, {});
    const std::int32_t V = mesh.n_vertices(), F = mesh.n_faces(), face = 17;
    const auto site = *mesh.split_site(face);
    std::array<std::int32_t, 3> neighbour;
    for (std::int32_t i = 0; i < 3; ++i) neighbour[static_cast<std::size_t>(i)] = mesh.twin(3 * face + i) / 3;
    mesh.split(face, no_move);

    const auto triangle = [&](std::int32_t f) { return mesh.triangles()[static_cast<std::size_t>(f)]; };
    for (std::int32_t v = V; v < V + 3; ++v) REQUIRE(mesh.valence(v) == 5);  // near-equilateral faces: no flip
    CHECK(triangle(face) == Triangle{V, V + 1, V + 2});
    for (std::int32_t i = 0; i < 3; ++i) {
        const auto k = static_cast<std::size_t>(i);
        CHECK(triangle(F + i) == Triangle{site[k], V + i, V + (i + 2) % 3});
        CHECK(triangle(F + 3 + i) == Triangle{V + i, site[k], site[k + 3]});
        const Triangle kept = triangle(neighbour[k]);
        CHECK(std::set(kept.begin(), kept.end()) == std::set{site[(k + 1) % 3], V + i, site[k + 3]});
    }
}

TEST_CASE("RefinableMesh: a split without scalars leaves a flat side flat") {
    const Grid grid = samples::unit_grid(12);
    RefinableMesh mesh(samples::flat_cube(grid, 4), grid, {});
    const std::int32_t top = 3 << (grid.bits - 2);  // z = 0.5
    const auto inside = [&](std::int32_t face) {    // on the top side, two rings away from its border
        for (const std::int32_t v : mesh.triangles()[static_cast<std::size_t>(face)]) {
            const GridPoint& p = mesh.positions()[static_cast<std::size_t>(v)];
            const std::int32_t half = 1 << (grid.bits - 1), reach = 1 << (grid.bits - 4);
            if (p.z != top || std::abs(p.x - half) > reach || std::abs(p.y - half) > reach) return false;
        }
        return true;
    };
    int n_split = 0;
    for (std::int32_t f = 0; f < mesh.n_faces() && n_split < 40; ++f) {
        if (!inside(f) || !mesh.split_site(f)) continue;
        const std::int32_t V = mesh.n_vertices();
        mesh.split(f, no_move);
        ++n_split;
        for (std::int32_t v = V; v < V + 3; ++v) REQUIRE(mesh.positions()[static_cast<std::size_t>(v)].z == top);
    }
    CHECK(n_split > 10);
}

TEST_CASE("RefinableMesh: on a sphere the predicted vertices lie far nearer to it than the edges' midpoints") {
    const Grid grid = samples::unit_grid(14);
    RefinableMesh mesh(samples::icosphere(grid, 2), grid, {});
    const auto height = [&](const Vec3& grid_point) {
        return std::fabs((grid.origin + grid.unit * grid_point).norm() - 0.75);
    };
    double predicted = 0, midpoints = 0;
    for (const std::int32_t face : {0, 50, 100, 150, 200, 250, 300}) {
        const Triangle t = mesh.triangles()[static_cast<std::size_t>(face)];
        const auto at = [&](std::size_t i) {
            const GridPoint& p = mesh.positions()[static_cast<std::size_t>(t[i])];
            return Vec3(p.x, p.y, p.z);
        };
        for (std::size_t i = 0; i < 3; ++i) midpoints += height((at(i) + at((i + 1) % 3)) / 2);
        mesh.split(face, [&](const ScalarSite& site) {
            if (site.slot < 3) predicted += height(site.position);
            return 0;
        });
    }
    CHECK(predicted < midpoints / 3);
}

TEST_CASE("RefinableMesh: the nine sites come in order, with unit normals and power-of-two steps") {
    const Grid grid = samples::unit_grid(12);
    RefinableMesh mesh(samples::icosphere(grid, 1), grid, {});
    const auto site = *mesh.split_site(7);
    const std::int32_t V = mesh.n_vertices();
    int expected_slot = 0;
    mesh.split(7, [&](const ScalarSite& s) {
        CHECK(s.slot == expected_slot++);
        CHECK(s.vertex == (s.slot < 3 ? V + s.slot : site[static_cast<std::size_t>(s.slot - 3)]));
        CHECK(s.normal.norm() == doctest::Approx(1));
        CHECK(std::exp2(std::round(std::log2(s.step))) == s.step);
        return 0;
    });
    CHECK(expected_slot == 9);
}

TEST_CASE("RefinableMesh: a scalar moves its vertex by so many steps along the normal, to the nearest grid point") {
    const Grid grid = samples::unit_grid(12);
    RefinableMesh mesh(samples::icosphere(grid, 1), grid, {});
    ScalarSite seen;
    mesh.split(7, [&](const ScalarSite& s) {
        if (s.slot == 8) seen = s;
        return s.slot == 8 ? 5 : 0;
    });
    const Vec3 expected = seen.position + 5 * seen.step * seen.normal;
    const GridPoint& p = mesh.positions()[static_cast<std::size_t>(seen.vertex)];
    CHECK((Vec3(p.x, p.y, p.z) - expected).cwiseAbs().maxCoeff() <= 0.5);
}

TEST_CASE("RefinableMesh: a chosen scalar that would leave the grid is reduced, and the record says so") {
    const Grid grid = samples::unit_grid(10);
    RefinableMesh mesh(samples::icosphere(grid, 1), grid, {});
    RefinableMesh replayed = mesh;
    const SplitRecord record = mesh.split(3, [](const ScalarSite&) { return 1 << 30; });
    for (const std::int32_t scalar : record.residual) CHECK(scalar < 1 << 12);
    CHECK(testing::fault_of(mesh) == "");
    replayed.apply(record);
    CHECK(testing::same_state(mesh, replayed));
}

}  // namespace anyrate
