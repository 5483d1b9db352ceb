#include "core/progressive/curvature_metric.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>

namespace anyrate {
namespace {

using Field = std::function<LatticeVector(double x, double y)>;

/// Three points near the origin, counter-clockwise from above and turned by an angle, and their normals.
struct Face {
    std::array<LatticeVector, 3> corners, normals;
};
Face face_on(const Field& point, const Field& gradient, double turn) {
    constexpr double size = 0.01;
    Face face;
    for (std::size_t i = 0; i < 3; ++i) {
        const double angle = turn + std::array{0.3, 2.2, 4.5}[i];
        const double x = size * std::cos(angle), y = size * std::sin(angle);
        face.corners[i] = point(x, y);
        const LatticeVector normal = gradient(x, y);
        face.normals[i] = normal / length(normal);
    }
    return face;
}

/// The graph of z = (a x^2 + c y^2) / 2, whose curvatures at the origin are -a and -c.
Face face_on_paraboloid(double a, double c, double turn) {
    return face_on(
        [&](double x, double y) {
            return LatticeVector{x, y, (a * x * x + c * y * y) / 2};
        },
        [&](double x, double y) {
            return LatticeVector{-a * x, -c * y, 1};
        },
        turn);
}

constexpr LatticeVector x_axis{1, 0, 0}, y_axis{0, 1, 0};

}  // namespace

TEST_CASE("Curvature metric: the absolute curvatures, and 5/16 of their mean in all directions") {
    for (const auto& [a, c] : {std::pair(1.0, 1.0), std::pair(-2.0, -0.5), std::pair(3.0, 0.0), std::pair(1.0, -4.0)}) {
        const double more = 0.3125 * (std::abs(a) + std::abs(c)) / 2;
        for (const double turn : {0.0, 0.7, 2.0, 5.0}) {
            const Face face = face_on_paraboloid(a, c, turn);
            const auto metric = curvature_metric(face.corners, face.normals);
            REQUIRE(metric);
            CHECK(metric->inner_product(x_axis, x_axis) == doctest::Approx(std::abs(a) + more).epsilon(0.01));
            CHECK(metric->inner_product(y_axis, y_axis) == doctest::Approx(std::abs(c) + more).epsilon(0.01));
            CHECK(std::abs(metric->inner_product(x_axis, y_axis)) < 0.01 * (std::abs(a) + std::abs(c)));
        }
    }
}

TEST_CASE("Curvature metric: an inner product is symmetric and linear") {
    const Face face = face_on_paraboloid(2, 0.3, 1);
    const auto metric = curvature_metric(face.corners, face.normals);
    REQUIRE(metric);
    const LatticeVector a{1, 2, 3}, b{-2, 0.5, 1}, c{0, 3, -1};
    CHECK(metric->inner_product(a, b) == doctest::Approx(metric->inner_product(b, a)));
    CHECK(metric->inner_product(a + 2 * c, b) ==
          doctest::Approx(metric->inner_product(a, b) + 2 * metric->inner_product(c, b)));
    CHECK(metric->inner_product(a, a) > 0);
}

TEST_CASE("Curvature metric: which corner comes first does not matter") {
    const Face face = face_on_paraboloid(1, 0.2, 0.4);
    const auto& [c0, c1, c2] = face.corners;
    const auto& [n0, n1, n2] = face.normals;
    const auto metric = curvature_metric(face.corners, face.normals);
    const auto turned = curvature_metric({c1, c2, c0}, {n1, n2, n0});
    REQUIRE(metric);
    REQUIRE(turned);
    for (const LatticeVector& a : {x_axis, y_axis, LatticeVector{1, 1, 0}})
        CHECK(metric->inner_product(a, a) == doctest::Approx(turned->inner_product(a, a)));
}

TEST_CASE("Curvature metric: there is none without area or curvature") {
    const Face plane = face_on_paraboloid(0, 0, 0);
    CHECK_FALSE(curvature_metric(plane.corners, plane.normals));
    const std::array<LatticeVector, 3> line = {LatticeVector{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
    CHECK_FALSE(curvature_metric(line, plane.normals));
    CHECK_FALSE(curvature_metric({}, plane.normals));
}

}  // namespace anyrate
