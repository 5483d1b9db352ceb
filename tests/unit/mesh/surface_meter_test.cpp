#include "core/mesh/surface_meter.h"

#include <doctest/doctest.h>

#include <numbers>
#include <numeric>
#include <random>

#include "core/mesh/coarse_fit.h"
#include "core/mesh/decimate.h"
#include "core/mesh/normal_fit.h"
#include "core/mesh/normals.h"
#include "core/mesh/triangle_shape.h"
#include "core/simulation/parametric_meshes.h"

using namespace anyrate;

namespace {

struct Total {
    double area = 0, squared = 0, slope = 0;
};

/// Of all faces; `slope` is the derivative if every vertex moves outward alike.
Total total(const Mesh& mesh, const TrueSurface& surface) {
    SurfaceMeter meter(surface);
    Total sum;
    for (const FaceDistance& face : meter.measure(mesh, vertex_normals(mesh))) {
        sum.area += face.area;
        sum.squared += face.squared;
        sum.slope += face.gradient[0] + face.gradient[1] + face.gradient[2];
    }
    return sum;
}

}  // namespace

TEST_CASE("Surface meter: two concentric spheres are the difference of their radii apart") {
    const TrueSurface surface(icosphere(5), 60'000);
    const Total sum = total(icosphere(5, 0.9), surface);
    CHECK(sum.squared / sum.area == doctest::Approx(0.01).epsilon(0.02));
    // Half of each area was measured.
    CHECK(sum.area == doctest::Approx(2 * std::numbers::pi * (1 + 0.81)).epsilon(0.02));
}

TEST_CASE("Surface meter: the gradient is the slope of the squared distance") {
    const TrueSurface surface(icosphere(5), 60'000);
    // E(r) of a sphere of radius r, with areas held as they are, falls by 2 (1 - r) times the area for each unit of r.
    const Total sum = total(icosphere(5, 0.9), surface);
    CHECK(sum.slope == doctest::Approx(-2 * 0.1 * sum.area).epsilon(0.02));
}

TEST_CASE("Surface meter: a face that is turned over is as far off as what is near it, not as the object's far side") {
    const TrueSurface surface(icosphere(5), 60'000);
    Mesh mesh = icosphere(3);
    const double whole = total(mesh, surface).squared;
    const auto [a, b, c] = mesh.triangles[0];
    const auto at = [&](std::int32_t v) -> Vec3& { return mesh.vertices[static_cast<std::size_t>(v)]; };
    const Vec3 middle = 0.5 * (at(a) + at(b));
    at(c) = middle + 0.1 * (middle - at(c));
    REQUIRE(twice_area_vector(at(a), at(b), at(c)).dot(middle) < 0);
    CHECK(total(mesh, surface).squared < 2 * whole);
}

TEST_CASE("Normal fit: the vertices of a coarse sphere that fits a fine one best lie outside it") {
    const TrueSurface surface(icosphere(5), 60'000);
    SurfaceMeter meter(surface);
    Mesh mesh = icosphere(2);
    const Total inscribed = total(mesh, surface);
    std::vector<std::int32_t> all(mesh.vertices.size());
    std::iota(all.begin(), all.end(), 0);
    fit_along_normals(mesh, all, meter, {.rounds = 3});
    for (const Vec3& v : mesh.vertices) CHECK(v.norm() > 1.0);
    // Of an arc of sagitta s above its chord the mean square is 8/15 s^2, about the best parallel chord 4/45 s^2, a
    // sixth.
    CHECK(total(mesh, surface).squared < inscribed.squared / 4);
}

TEST_CASE("Normal fit: vertices that are not active stay") {
    const TrueSurface surface(icosphere(4), 60'000);
    SurfaceMeter meter(surface);
    Mesh mesh = icosphere(2, 0.9);
    const Mesh before = mesh;
    const std::vector<std::int32_t> active{5, 40};
    const std::vector<double> costs = fit_along_normals(mesh, active, meter, {});
    REQUIRE(costs.size() == mesh.vertices.size());
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        CHECK((mesh.vertices[v] != before.vertices[v]) == (v == 5 || v == 40));
        CHECK(costs[v] > 0);
    }
}

TEST_CASE("Coarse fit: a fitted simplification of a sphere is nearer to it than an inscribed one") {
    const Mesh sphere = icosphere(5);
    const TrueSurface surface(sphere, 60'000);
    SurfaceMeter meter(surface);
    const Mesh coarse = fit_coarse_mesh(sphere, 162, meter);
    CHECK(coarse.n_vertices() <= 162);
    CHECK(total(coarse, surface).squared < total(icosphere(2), surface).squared / 4);
}

TEST_CASE("Coarse fit: noise of the fitted surface is averaged over, not simplified") {
    const Mesh clean = icosphere(5);
    Mesh noisy = clean;
    std::mt19937 random(7);
    for (Vec3& v : noisy.vertices) v *= 1 + 0.002 * (2.0 * random() / std::mt19937::max() - 1);
    const TrueSurface surface(noisy, 100'000), truth(clean, 100'000);
    SurfaceMeter meter(surface), again(surface);
    Mesh in_one_stage = decimate(noisy, 600);
    std::vector<std::int32_t> all(in_one_stage.vertices.size());
    std::iota(all.begin(), all.end(), 0);
    fit_along_normals(in_one_stage, all, meter, {.rounds = 3});
    CHECK(total(fit_coarse_mesh(noisy, 600, again), truth).squared < total(in_one_stage, truth).squared);
}

TEST_CASE("Normal fit: no move turns a face over, however far the surface is") {
    // A thin lens inside the unit sphere: its two sides are drawn outward, at the rim past each other.
    Mesh lens = icosphere(3);
    for (Vec3& v : lens.vertices) v.z() *= 0.02;
    const TrueSurface surface(icosphere(5), 60'000);
    SurfaceMeter meter(surface);
    const Mesh before = lens;
    std::vector<std::int32_t> all(lens.vertices.size());
    std::iota(all.begin(), all.end(), 0);
    fit_along_normals(lens, all, meter, {.most_edges = 2});
    bool any_moved = false;
    for (const auto& corners : lens.triangles) {
        const auto normal_in = [&](const Mesh& mesh) {
            const auto at = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(corners[k])]; };
            return twice_area_vector(at(0), at(1), at(2)).normalized();
        };
        CHECK(normal_in(before).dot(normal_in(lens)) >= 0.5 - 1e-12);
        any_moved = any_moved || lens.vertices[static_cast<std::size_t>(corners[0])] !=
                                     before.vertices[static_cast<std::size_t>(corners[0])];
    }
    CHECK(any_moved);
}
