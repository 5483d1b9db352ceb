#include "core/reconstruction/initial_mesh.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/mesh/topology.h"
#include "core/simulation/simulate.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

// The surface that a profile of (radius, height) makes by turning around the z axis; its ends lie on the axis. Outward
// if the profile runs from the bottom along the outside to the top.
Mesh turned(const std::vector<Vec2>& profile, int n_around) {
    Mesh mesh;
    mesh.vertices.push_back({0, 0, profile.front().y()});
    mesh.vertices.push_back({0, 0, profile.back().y()});
    const int n_rings = static_cast<int>(profile.size()) - 2;
    for (int r = 1; r <= n_rings; ++r)
        for (int i = 0; i < n_around; ++i) {
            const double angle = 2 * std::numbers::pi * i / n_around;
            const Vec2& p = profile[static_cast<std::size_t>(r)];
            mesh.vertices.push_back({p.x() * std::cos(angle), p.x() * std::sin(angle), p.y()});
        }
    const auto vertex = [&](int ring, int i) { return 2 + ring * n_around + i % n_around; };
    for (int i = 0; i < n_around; ++i) {
        mesh.triangles.push_back({0, vertex(0, i + 1), vertex(0, i)});
        mesh.triangles.push_back({1, vertex(n_rings - 1, i), vertex(n_rings - 1, i + 1)});
        for (int r = 0; r + 1 < n_rings; ++r) {
            mesh.triangles.push_back({vertex(r, i), vertex(r, i + 1), vertex(r + 1, i)});
            mesh.triangles.push_back({vertex(r, i + 1), vertex(r + 1, i + 1), vertex(r + 1, i)});
        }
    }
    return mesh;
}

double volume(const Mesh& mesh) {
    double sum = 0;
    for (const Triangle& t : mesh.triangles) {
        const auto corner = [&](std::size_t k) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
        sum += corner(0).dot(corner(1).cross(corner(2))) / 6;
    }
    return sum;
}

InitialSurface initial_surface_of(const Capture& capture) {
    const PhotoImages images = make_photo_images(capture);
    return initial_surface(visual_hull(capture, hull_options(images)), images, {});
}

}  // namespace

TEST_CASE("Initial surface: the inside of a dish, which no silhouette shows, is open") {
    const Mesh dish = turned({{0, 0}, {0.6, 0}, {1, 0.6}, {0.85, 0.6}, {0.5, 0.15}, {0, 0.15}}, 64);
    const double filled = volume(turned({{0, 0}, {0.6, 0}, {1, 0.6}, {0, 0.6}}, 64));
    const Simulation scene = simulate_mesh(dish, {.width = 320, .height = 240});
    const InitialSurface initial = initial_surface_of(scene.capture);
    REQUIRE(measure_topology(initial.mesh).is_closed_manifold());
    const double missing = filled - volume(dish);
    CHECK(volume(initial.mesh) == doctest::Approx(volume(dish)).epsilon(0.15));
    CHECK(volume(initial.mesh) < filled - 0.7 * missing);
}

TEST_CASE("Hull options: the grid that the surface starts on does not depend on how large the photographs are") {
    const auto cell = [](int size_px) {
        const Capture capture = painted_sphere(6, size_px, wavy_paint);
        return visual_hull(capture, hull_options(make_photo_images(capture))).cell;
    };
    for (const int size_px : {160, 640}) CHECK(cell(size_px) == doctest::Approx(cell(320)).epsilon(0.05));
}

TEST_CASE("Initial surface: the demo's vessel keeps its two handles, and its stem no hole") {
    const Simulation scene = simulate_scene("vessel", {.width = 320, .height = 240});
    const Topology topology = measure_topology(initial_surface_of(scene.capture).mesh);
    REQUIRE(topology.is_closed_manifold());
    CHECK(topology.n_components == 1);
    CHECK(topology.n_components - topology.euler / 2 == 2);
}

TEST_CASE("Initial surface: no cone below what stands on a table") {
    // Views from 20 degrees above see nothing of the underside: their silhouettes' hull goes on below it.
    const Mesh column = turned({{0, 0}, {0.8, 0}, {0.8, 1.2}, {0, 1.2}}, 64);
    const Simulation scene = simulate_mesh(column, {.width = 320, .height = 240});
    const PhotoImages images = make_photo_images(scene.capture);
    const VisualHull hull = visual_hull(scene.capture, hull_options(images));
    const InitialSurface initial = initial_surface(hull, images, {});
    double lowest = 0;
    for (const Vec3& v : initial.mesh.vertices) lowest = std::min(lowest, v.z());
    REQUIRE(hull.lower.z() < -0.15);
    CHECK(lowest > 0.25 * hull.lower.z());
}
