#include "core/encoding/surface_meter.h"

#include <doctest/doctest.h>

#include <numbers>
#include <numeric>

#include "core/encoding/normal_fit.h"
#include "core/encoding/surface_colours.h"
#include "core/mesh/normals.h"
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

TEST_CASE("Surface colours: between coloured vertices the colours are interpolated") {
    Mesh mesh = icosphere(3);
    for (const Vec3& v : mesh.vertices)
        mesh.colours.push_back(
            {static_cast<std::uint8_t>(127 + 120 * v.x()), 80, static_cast<std::uint8_t>(127 + 120 * v.z())});
    const NearestSurface nearest(mesh);
    const std::vector<Vec3> points{{1.2, 0, 0}, {0, 0.9, 0}, {0.6, 0, -0.8}};
    const std::vector<Rgb8> colours = surface_colours(mesh, nearest, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3 on = points[i].normalized();
        CHECK(colours[i].r == doctest::Approx(127 + 120 * on.x()).epsilon(0.02));
        CHECK(colours[i].g == 80);
        CHECK(colours[i].b == doctest::Approx(127 + 120 * on.z()).epsilon(0.1));
    }
    CHECK(surface_colours(icosphere(1), nearest, points).empty());
}
