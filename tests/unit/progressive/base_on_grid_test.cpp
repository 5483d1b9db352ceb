#include "core/progressive/base_on_grid.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>

#include "core/mesh/triangle_shape.h"
#include "core/simulation/parametric_meshes.h"

using namespace anyrate;

namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

Vec3 area_vector(const Mesh& mesh, const Triangle& t) {
    return twice_area_vector(mesh.vertices[at(t[0])], mesh.vertices[at(t[1])], mesh.vertices[at(t[2])]);
}

Mesh in_world(const BaseMesh& base, const Grid& grid) {
    Mesh mesh{{}, base.triangles, {}};
    for (const GridPoint& p : base.positions) mesh.vertices.push_back(grid.to_world(p));
    return mesh;
}

/// Root mean square of how far the vertices of a rounded unit sphere are off it.
double roundness(const BaseMesh& base, const Grid& grid) {
    double sum = 0;
    for (const GridPoint& p : base.positions) sum += std::pow(grid.to_world(p).norm() - 1, 2);
    return std::sqrt(sum / static_cast<double>(base.positions.size()));
}

}  // namespace

TEST_CASE("Base on the grid: vertices slide along the surface to positions that lie on it") {
    const Mesh sphere = icosphere(4);
    const Grid grid = make_grid(sphere, 10'000);
    const BaseMesh base = to_base(sphere, grid), nearest = nearest_base(sphere, grid);
    const double cell = std::ldexp(grid.unit, grid.base_shift);
    CHECK(roundness(base, grid) < 0.5 * roundness(nearest, grid));
    for (std::size_t v = 0; v < sphere.vertices.size(); ++v) {
        const Vec3 way = grid.to_world(base.positions[v]) - sphere.vertices[v];
        CHECK(way.cwiseAbs().maxCoeff() < 2.6 * cell);
        const Vec3 to_nearest = grid.to_world(nearest.positions[v]) - sphere.vertices[v];
        CHECK(to_nearest.cwiseAbs().maxCoeff() < 0.501 * cell);
    }
}

TEST_CASE("Base on the grid: the positions are multiples of the base shift and within the grid") {
    const Mesh sphere = icosphere(2);
    Grid grid = make_grid(sphere, 10'000);
    SUBCASE("as make_grid() gives it") {}
    SUBCASE("on the coarsest lattice") { grid.base_shift = grid.bits - 2; }
    SUBCASE("a grid that ends at the mesh") {
        grid.origin = Vec3::Constant(-1);
        grid.unit = 2 / (std::ldexp(1.0, grid.bits) - 1);
    }
    const std::int32_t cell = 1 << grid.base_shift, end = 1 << grid.bits;
    for (const BaseMesh& base : {to_base(sphere, grid), nearest_base(sphere, grid)})
        for (const GridPoint& p : base.positions)
            for (const std::int32_t x : {p.x, p.y, p.z}) {
                CHECK(x % cell == 0);
                CHECK(x >= 0);
                CHECK(x < end);
            }
}

TEST_CASE("Base on the grid: what lies on it already stays where it is") {
    const Mesh sphere = icosphere(3);
    const Grid grid = make_grid(sphere, 10'000);
    const BaseMesh once = to_base(sphere, grid);
    CHECK(to_base(in_world(once, grid), grid).positions == once.positions);
    CHECK(nearest_base(in_world(once, grid), grid).positions == once.positions);
}

TEST_CASE("Base on the grid: no face folds where edges are a few cells long") {
    Mesh sphere = icosphere(3);
    for (Vec3& v : sphere.vertices) v.z() *= 0.1;  // flat, with narrow faces around its rim
    Grid grid = make_grid(sphere, 10'000);
    grid.base_shift += 2;
    const Mesh rounded = in_world(to_base(sphere, grid), grid);
    for (const Triangle& t : sphere.triangles) CHECK(area_vector(rounded, t).dot(area_vector(sphere, t)) > 0);
}

TEST_CASE("Base on the grid: the finer the mesh, the finer its positions") {
    const Grid grid = make_grid(icosphere(3), 10'000);
    CHECK(base_shift(icosphere(4), grid) == base_shift(icosphere(3), grid) - 1);
    CHECK(base_shift(icosphere(5), grid) == base_shift(icosphere(3), grid) - 2);
    Mesh point = icosphere(0);
    for (Vec3& v : point.vertices) v *= 1e-9;
    CHECK(base_shift(point, grid) == 0);
}
