#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/mesh/topology.h"
#include "tests/scenes.h"

namespace anyrate {
namespace {

double area(const Mesh& mesh) {
    double twice = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        twice += (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm();
    }
    return twice / 2;
}

/// Positive if the triangles are counter-clockwise seen from outside.
double volume(const Mesh& mesh) {
    double six_times = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        six_times += mesh.vertices[a].dot(mesh.vertices[b].cross(mesh.vertices[c]));
    }
    return six_times / 6;
}

}  // namespace

TEST_CASE("Icosphere: every vertex lies on the sphere, and the surface is a closed manifold of genus 0") {
    const Vec3 centre(3, -2, 5);
    const Mesh mesh = icosphere(3, 2.5, centre);
    for (const Vec3& vertex : mesh.vertices) CHECK((vertex - centre).norm() == doctest::Approx(2.5));
    const Topology topology = measure_topology(mesh);
    CHECK(topology.is_closed_manifold());
    CHECK(topology.n_faces == 20 * 64);
    CHECK(topology.euler == 2);
}

TEST_CASE("Icosphere: its volume approaches the ball's fourfold faster with each subdivision") {
    const double ball = 4.0 / 3.0 * std::numbers::pi;
    double previous = ball - volume(icosphere(1));
    for (int subdivisions = 2; subdivisions <= 5; ++subdivisions) {
        const double missing = ball - volume(icosphere(subdivisions));
        CHECK(missing > 0);
        CHECK(previous / missing == doctest::Approx(4).epsilon(0.1));
        previous = missing;
    }
}

TEST_CASE("Torus: a closed manifold of genus 1 with the volume of Pappus' theorem") {
    const Mesh mesh = torus(2.0, 0.5, 200, 100);
    const Topology topology = measure_topology(mesh);
    CHECK(topology.is_closed_manifold());
    CHECK(topology.euler == 0);
    const double pappus = 2 * std::numbers::pi * 2.0 * std::numbers::pi * 0.25;
    CHECK(volume(mesh) == doctest::Approx(pappus).epsilon(2e-3));
}

TEST_CASE("Cube surface: 6 n^2 + 2 vertices, area 24, volume 8, closed and manifold") {
    for (const int n : {1, 2, 5}) {
        const Mesh mesh = cube_surface(n);
        CHECK(mesh.n_vertices() == 6 * n * n + 2);
        CHECK(mesh.n_faces() == 12 * n * n);
        CHECK(area(mesh) == doctest::Approx(24));
        CHECK(volume(mesh) == doctest::Approx(8));
        CHECK(measure_topology(mesh).is_closed_manifold());
    }
}

}  // namespace anyrate
