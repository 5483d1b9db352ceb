#include <doctest/doctest.h>

#include "core/error.h"
#include "tests/golden/sample_models.h"
#include "tests/unit/progressive/closed_manifold.h"

namespace anyrate {
namespace {

const Grid grid = samples::unit_grid(10);

/// Two pyramids over an n-gon: its two poles have valence n.
BaseMesh bipyramid(std::int32_t n) {
    BaseMesh base;
    for (std::int32_t i = 0; i < n; ++i) base.positions.push_back({8 * i, (i * i) % 512, 512});
    base.positions.push_back({512, 512, 900});
    base.positions.push_back({512, 512, 100});
    for (std::int32_t i = 0; i < n; ++i) {
        base.triangles.push_back({i, (i + 1) % n, n});
        base.triangles.push_back({(i + 1) % n, i, n + 1});
    }
    return base;
}

}  // namespace

TEST_CASE("RefinableMesh: sound bases of genus 0 and 1 are accepted") {
    const RefinableMesh sphere(samples::icosphere(grid, 1), grid, {});
    CHECK(testing::fault_of(sphere) == "");
    CHECK(testing::euler_characteristic(sphere) == 2);
    const RefinableMesh torus(samples::square_torus(grid), grid, {});
    CHECK(testing::fault_of(torus) == "");
    CHECK(testing::euler_characteristic(torus) == 0);
}

TEST_CASE("RefinableMesh: a base that is not a closed oriented manifold is refused") {
    const BaseMesh sound = samples::octahedron(grid);
    BaseMesh base = sound;
    SUBCASE("a face is missing") { base.triangles.pop_back(); }
    SUBCASE("a face is turned over") { std::swap(base.triangles[0][0], base.triangles[0][1]); }
    SUBCASE("a face occurs twice") { base.triangles.push_back(base.triangles[0]); }
    SUBCASE("a corner is repeated") { base.triangles[0][1] = base.triangles[0][0]; }
    SUBCASE("a corner is negative") { base.triangles[0][1] = -1; }
    SUBCASE("a corner is beyond the vertices") { base.triangles[0][1] = 6; }
    SUBCASE("a vertex has no face") { base.positions.push_back({0, 0, 0}); }
    SUBCASE("two surfaces share a vertex") {
        for (Triangle t : sound.triangles) {
            for (std::int32_t& v : t) v = v == 0 ? 0 : v + 5;
            base.triangles.push_back(t);
        }
        base.positions.resize(11);
    }
    SUBCASE("two triangles lie back to back") {
        base = {{{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 9}}, {{0, 1, 2}, {0, 2, 1}}};
    }
    SUBCASE("a position is negative") { base.positions[2].y = -4; }
    SUBCASE("a position is beyond the grid") { base.positions[2].y = 1024; }
    SUBCASE("nothing is there") { base = {}; }
    CHECK_THROWS_AS(RefinableMesh(base, grid, {}), DecodeError);
}

TEST_CASE("RefinableMesh: grids and step ratios out of range are refused") {
    const BaseMesh base = samples::octahedron(grid);
    Grid wide = grid;
    wide.bits = 21;
    CHECK_THROWS_AS(RefinableMesh(base, wide, {}), DecodeError);
    CHECK_THROWS_AS(RefinableMesh(base, grid, {.step_ratio = 0}), DecodeError);
}

TEST_CASE("RefinableMesh: a face is split only if its six vertices are different") {
    const BaseMesh tetrahedron = {{{100, 100, 100}, {900, 100, 100}, {500, 900, 100}, {500, 500, 900}},
                                  {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
    RefinableMesh mesh(tetrahedron, grid, {});
    CHECK_FALSE(mesh.split_site(0));
    CHECK_THROWS_AS(mesh.apply({.face = 0}), DecodeError);
    CHECK_THROWS_AS(mesh.split(0, [](const ScalarSite&) { return 0; }), InputError);
}

TEST_CASE("RefinableMesh: the split site of an octahedron's face is all of its vertices") {
    const RefinableMesh mesh(samples::octahedron(grid), grid, {});
    // Across edge 0-1 lies vertex 5, across 1-2 vertex 3, across 2-0 vertex 4.
    CHECK(mesh.split_site(0) == std::array<std::int32_t, 6>{0, 1, 2, 5, 3, 4});
}

TEST_CASE("RefinableMesh: faces at a vertex of 64 edges are not split, those at one of 63 are") {
    CHECK_FALSE(RefinableMesh(bipyramid(64), grid, {}).split_site(0));
    CHECK(RefinableMesh(bipyramid(63), grid, {}).split_site(0));
}

TEST_CASE("RefinableMesh: faces that do not exist have no split site") {
    RefinableMesh mesh(samples::octahedron(grid), grid, {});
    CHECK_FALSE(mesh.split_site(-1));
    CHECK_FALSE(mesh.split_site(8));
    CHECK_THROWS_AS(mesh.apply({.face = 8}), DecodeError);
}

}  // namespace anyrate
