#include "core/simulation/polygonize.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/mesh/topology.h"

namespace anyrate {
namespace {

constexpr double major_radius = 0.7, minor_radius = 0.25;

double ball_field(const Vec3& p) { return p.squaredNorm() - 1; }  // not a distance, on purpose
double ring_field(const Vec3& p) { return length(length(p.x(), p.y()) - major_radius, p.z()) - minor_radius; }

PolygonizeOptions box(double half_size, double cell) {
    return {.low = Vec3::Constant(-half_size), .high = Vec3::Constant(half_size), .cell = cell};
}

/// 1 for an equilateral triangle, 0 for a degenerate one.
double shape_quality(const Mesh& mesh, const Triangle& triangle) {
    const Vec3 a = mesh.vertices[triangle[1]] - mesh.vertices[triangle[0]];
    const Vec3 b = mesh.vertices[triangle[2]] - mesh.vertices[triangle[0]];
    return 2 * std::sqrt(3) * a.cross(b).norm() / (a.squaredNorm() + b.squaredNorm() + (a - b).squaredNorm());
}

}  // namespace

TEST_CASE("Polygonize: the surface of a ball is a sphere, closed, wound outwards, vertices on it") {
    const Mesh mesh = polygonize(ball_field, box(1.3, 0.11));
    const Topology topology = measure_topology(mesh);
    CHECK(topology.is_closed_manifold());
    CHECK(topology.n_components == 1);
    CHECK(topology.euler == 2);
    double worst = 0, volume = 0;
    for (const Vec3& vertex : mesh.vertices) worst = std::max(worst, std::abs(vertex.norm() - 1));
    for (const auto& [a, b, c] : mesh.triangles) {
        volume += mesh.vertices[a].dot(mesh.vertices[b].cross(mesh.vertices[c])) / 6;
    }
    CHECK(worst < 1e-6);
    CHECK(volume == doctest::Approx(4.18879).epsilon(0.01));
}

TEST_CASE("Polygonize: a ring has one handle") {
    const Topology topology = measure_topology(polygonize(ring_field, box(1.2, 0.08)));
    CHECK(topology.is_closed_manifold());
    CHECK(topology.euler == 0);
}

TEST_CASE("Polygonize: lattice points exactly on the surface do no harm") {
    // The planes of this cube go through the lattice's corners.
    const auto cube = [](const Vec3& p) { return p.cwiseAbs().maxCoeff() - 0.5; };
    const Topology topology = measure_topology(polygonize(cube, box(1.0, 0.125)));
    CHECK(topology.is_closed_manifold());
    CHECK(topology.euler == 2);
}

TEST_CASE("Polygonize: no triangle of a smooth surface is a sliver") {
    const Mesh mesh = polygonize(ring_field, box(1.2, 0.05));
    double worst = 1;
    for (const Triangle& triangle : mesh.triangles) worst = std::min(worst, shape_quality(mesh, triangle));
    CHECK(worst > 0.4);
}

}  // namespace anyrate
