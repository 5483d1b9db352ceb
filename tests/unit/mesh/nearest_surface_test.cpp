#include "core/mesh/nearest_surface.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/error.h"
#include "core/mesh/closest_point.h"
#include "shapes.h"

using namespace anyrate;

TEST_CASE("closest_point: the inside, every edge and every corner of a triangle") {
    const Vec3 a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
    CHECK(closest_point_on_triangle({0.5, 0.5, 3}, a, b, c).isApprox(Vec3(0.5, 0.5, 0)));
    CHECK(closest_point_on_triangle({1, -2, 1}, a, b, c).isApprox(Vec3(1, 0, 0)));
    CHECK(closest_point_on_triangle({-2, 1, 1}, a, b, c).isApprox(Vec3(0, 1, 0)));
    CHECK(closest_point_on_triangle({3, 3, 1}, a, b, c).isApprox(Vec3(1, 1, 0)));
    CHECK(closest_point_on_triangle({-1, -1, 1}, a, b, c) == a);
    CHECK(closest_point_on_triangle({4, -1, 1}, a, b, c) == b);
    CHECK(closest_point_on_triangle({-1, 4, 1}, a, b, c) == c);
}

TEST_CASE("barycentric: the weights make up the point and add up to 1") {
    const Vec3 a(0, 0, 1), b(2, 0, 0), c(0, 3, 0.5);
    const Vec3 p = 0.2 * a + 0.5 * b + 0.3 * c;
    CHECK(barycentric(p, a, b, c).isApprox(Vec3(0.2, 0.5, 0.3)));
    CHECK(barycentric(b, a, b, c).isApprox(Vec3(0, 1, 0)));
    CHECK(barycentric(p, a, a, a).sum() == doctest::Approx(1));
}

TEST_CASE("closest_point: a triangle without area is a segment or a point") {
    const Vec3 a(0, 0, 0), b(1, 0, 0), c(3, 0, 0), p(2, 1, 0);
    CHECK(closest_point_on_triangle(p, a, b, c).isApprox(Vec3(2, 0, 0)));
    CHECK(closest_point_on_triangle(p, a, a, c).isApprox(Vec3(2, 0, 0)));
    CHECK(closest_point_on_triangle(p, c, a, a).isApprox(Vec3(2, 0, 0)));
    CHECK(closest_point_on_triangle(p, b, b, b) == b);
}

TEST_CASE("NearestSurface: agrees with the search through all triangles, with and without hints") {
    const Mesh mesh = shapes::zero_set([](const Vec3& p) { return p.cwiseProduct(Vec3(1, 1.5, 2)).norm() - 0.7; }, 12);
    const NearestSurface surface(mesh);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
    std::int32_t hint = -1;
    for (int i = 0; i < 300; ++i) {
        const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
        double expected = std::numeric_limits<double>::infinity();
        for (const auto& [a, b, c] : mesh.triangles)
            expected = std::min(
                expected,
                (closest_point_on_triangle(p, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]) - p).squaredNorm());
        const auto hit = surface.nearest(p, hint);
        CHECK(hit.squared_distance == expected);
        CHECK((hit.point - p).squaredNorm() == expected);
        hint = hit.face;
    }
}

TEST_CASE("NearestSurface: exact also far from the origin, and of points far from the surface") {
    const Vec3 origin(3e6, -2e6, 1e6);
    const Mesh mesh = shapes::translated(
        shapes::zero_set([](const Vec3& p) { return p.cwiseProduct(Vec3(1, 1.5, 2)).norm() - 0.7; }, 12), origin);
    const NearestSurface surface(mesh);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(-1, 1);
    for (const double distance : {0.8, 50.0, 1e5})
        for (int i = 0; i < 100; ++i) {
            const Vec3 p =
                origin + distance * Vec3(coordinate(random), coordinate(random), coordinate(random)).normalized();
            double expected = std::numeric_limits<double>::infinity();
            for (const auto& [a, b, c] : mesh.triangles)
                expected = std::min(
                    expected, (closest_point_on_triangle(p, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]) - p)
                                  .squaredNorm());
            CHECK(surface.nearest(p).squared_distance == expected);
        }
}

TEST_CASE("NearestSurface: facing keeps a point on its own side of a thin sheet") {
    // Two horizontal triangles 0.1 apart, the upper one facing up, the lower one down.
    Mesh sheet;
    sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -0.1}, {1, 0, -0.1}, {0, 1, -0.1}};
    sheet.triangles = {{0, 1, 2}, {3, 5, 4}};
    const NearestSurface surface(sheet);
    const Vec3 p(0.2, 0.2, -0.09);
    CHECK(surface.nearest(p).face == 1);
    CHECK(surface.nearest_facing(p, Vec3::UnitZ()).face == 0);
    CHECK(surface.nearest_facing(p, Vec3::UnitX()).face == -1);
}

TEST_CASE("NearestSurface: a mesh without triangles is refused") {
    CHECK_THROWS_AS(NearestSurface(Mesh{}), InputError);
}
