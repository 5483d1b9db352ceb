#include "core/reconstruction/poisson.h"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/mesh/topology.h"
#include "core/reconstruction/iso_surface.h"

using namespace anyrate;

namespace {

constexpr double pi = 3.14159265358979323846;

// n points of near-equal area on a sphere: a spiral with the golden angle (Vogel's lattice).
std::vector<OrientedPoint> sphere_points(int n, double radius = 1.0, const Vec3& centre = Vec3::Zero()) {
    std::vector<OrientedPoint> points;
    for (int i = 0; i < n; ++i) {
        const double z = 1 - (2 * i + 1.0) / n, across = std::sqrt(1 - z * z), angle = i * pi * (3 - std::sqrt(5.0));
        const Vec3 normal(across * std::cos(angle), across * std::sin(angle), z);
        points.push_back({centre + radius * normal, normal, 4 * pi * radius * radius / n});
    }
    return points;
}

// Two points for every square of the spacing.
std::vector<OrientedPoint> sphere_points_for(double spacing) {
    return sphere_points(static_cast<int>(2 * 4 * pi / (spacing * spacing)));
}

double largest_radius_error(const Mesh& mesh) {
    double error = 0.0;
    for (const Vec3& v : mesh.vertices) error = std::max(error, std::abs(v.norm() - 1));
    return error;
}

float value_at_node(const ScalarField& field, int i, int j, int k) {
    return field.values[static_cast<std::size_t>((k * field.ny + j) * field.nx + i)];
}

}  // namespace

TEST_CASE("Poisson: the zero set of a sphere's points lies on the sphere to a tenth of the spacing") {
    const double spacing = 0.1;
    const Mesh mesh = iso_surface(poisson_field(sphere_points_for(spacing), {.spacing = spacing}));
    CHECK(measure_topology(mesh).n_components == 1);
    CHECK(largest_radius_error(mesh) < 0.1 * spacing);
}

TEST_CASE("Poisson: half the spacing gives less than half the error") {
    double last_error = 1.0;
    for (const double spacing : {0.2, 0.1, 0.05}) {
        const double error =
            largest_radius_error(iso_surface(poisson_field(sphere_points_for(spacing), {.spacing = spacing})));
        CHECK(error < 0.5 * last_error);
        last_error = error;
    }
}

TEST_CASE("Poisson: the field is the distance in spacings near the surface, and keeps its sign away from it") {
    const double spacing = 0.08;
    const ScalarField field = poisson_field(sphere_points_for(spacing), {.spacing = spacing});
    for (int k = 0; k < field.nz; ++k)
        for (int j = 0; j < field.ny; ++j)
            for (int i = 0; i < field.nx; ++i) {
                const double distance = ((field.origin + spacing * Vec3(i, j, k)).norm() - 1) / spacing;
                const double value = static_cast<double>(value_at_node(field, i, j, k));
                if (std::abs(distance) < 0.5) CHECK(value == doctest::Approx(distance).epsilon(0.15));
                if (std::abs(distance) > 1) CHECK(value * distance > 0);
            }
}

TEST_CASE("Poisson: the field is positive on the border of the grid") {
    const ScalarField field = poisson_field(sphere_points(500), {.spacing = 0.15});
    for (int k = 0; k < field.nz; ++k)
        for (int j = 0; j < field.ny; ++j)
            for (int i = 0; i < field.nx; ++i)
                if (i == 0 || j == 0 || k == 0 || i + 1 == field.nx || j + 1 == field.ny || k + 1 == field.nz)
                    REQUIRE(value_at_node(field, i, j, k) > 0.0f);
}

TEST_CASE("Poisson: a hole in the points is closed smoothly") {
    auto points = sphere_points_for(0.08);
    std::erase_if(points, [](const OrientedPoint& point) { return point.position.z() > 0.85; });
    const Mesh mesh = iso_surface(poisson_field(points, {.spacing = 0.08}));
    const Topology topology = measure_topology(mesh);
    CHECK(topology.is_closed_manifold());
    CHECK(topology.n_components == 1);
    double top = -1.0;
    for (const Vec3& v : mesh.vertices) top = std::max(top, v.z());
    CHECK(top > 0.8);
    CHECK(top < 1.2);
}

TEST_CASE("Poisson: a plate one and a half spacings thick stays whole") {
    // A round plate of radius 1 whose two faces are tilted against the grid.
    const double spacing = 0.1, thickness = 1.5 * spacing;
    const Vec3 normal = Vec3(1, 2, 4).normalized(), u = normal.unitOrthogonal(), v = normal.cross(u);
    std::vector<OrientedPoint> points;
    const double step = 0.6 * spacing;
    for (int a = -20; a <= 20; ++a)
        for (int b = -20; b <= 20; ++b) {
            const Vec3 middle = step * (a * u + b * v);
            if (middle.norm() > 1) continue;
            for (const double side : {-1.0, 1.0})
                points.push_back({middle + 0.5 * side * thickness * normal, side * normal, step * step});
        }
    const Topology topology = measure_topology(iso_surface(poisson_field(points, {.spacing = spacing})));
    CHECK(topology.n_components == 1);
    CHECK(topology.euler == 2);
}

TEST_CASE("Poisson: the scale and place of the points do not matter") {
    const ScalarField field = poisson_field(sphere_points(1000), {.spacing = 0.125});
    for (const double scale : {1e-3, 1e3}) {
        const Vec3 centre = scale * Vec3(100, -50, 20);
        const ScalarField same = poisson_field(sphere_points(1000, scale, centre), {.spacing = scale * 0.125});
        REQUIRE(same.values.size() == field.values.size());
        float difference = 0.0f;
        for (std::size_t i = 0; i < field.values.size(); ++i)
            if (std::abs(field.values[i]) < 0.5f)
                difference = std::max(difference, std::abs(field.values[i] - same.values[i]));
        CHECK(difference < 1e-3f);
    }
}

TEST_CASE("Poisson: one and two threads give the same bytes") {
    const auto points = sphere_points(3000);
    const auto with_threads = [&](std::size_t n) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, n);
        return poisson_field(points, {.spacing = 0.05}).values;
    };
    CHECK(with_threads(1) == with_threads(2));
}

TEST_CASE("Poisson: no points, or a grid beyond all bounds, are refused") {
    CHECK_THROWS_AS(poisson_field({}, {.spacing = 0.1}), InputError);
    CHECK_THROWS_AS(poisson_field(sphere_points(100), {.spacing = 1e-4}), InputError);
}

TEST_CASE("Poisson: the surface keeps out of what the votes call outside") {
    const double spacing = 0.1;
    // A ball without its cap above z = 0.5, where three views see into a pit down to z = 0.
    std::vector<OrientedPoint> points = sphere_points_for(spacing);
    std::erase_if(points, [](const OrientedPoint& point) { return point.position.z() > 0.5; });
    const VoteFn votes = [](const NodeRow& row, RowVotes& of_row) {
        for (std::size_t i = 0; i < of_row.sum.size(); ++i) {
            const Vec3 node = row.first + static_cast<double>(i) * row.spacing * Vec3::UnitX();
            const bool is_free = node.z() > 0 && node.head<2>().norm() < 0.5;
            of_row.sum[i] = of_row.weight[i] = is_free ? 3.0f : 0.0f;
        }
    };
    const auto height_on_axis = [&](const VoteFn& asked) {
        double z = -1;
        for (const Vec3& v : iso_surface(poisson_field(points, {.spacing = spacing}, asked)).vertices)
            if (v.head<2>().norm() < 0.15) z = std::max(z, v.z());
        return z;
    };
    CHECK(height_on_axis({}) > 0.4);
    CHECK(height_on_axis(votes) < 0.1);
}

TEST_CASE("Poisson: many votes weigh no more together than two that are certain, and doubtful ones weigh less") {
    const double spacing = 0.1;
    const std::vector<OrientedPoint> points = sphere_points_for(spacing);
    const auto field_with = [&](float weight) {
        return poisson_field(points, {.spacing = spacing}, [=](const NodeRow& row, RowVotes& of_row) {
            for (std::size_t i = 0; i < of_row.sum.size(); ++i) {
                const Vec3 node = row.first + static_cast<double>(i) * row.spacing * Vec3::UnitX();
                of_row.weight[i] = node.x() > 0.5 ? weight : 0.0f;  // outside, all of them say
                of_row.sum[i] = of_row.weight[i];
            }
        });
    };
    const auto volume = [](const ScalarField& field) {
        return std::ranges::count_if(field.values, [](float value) { return value < 0; });
    };
    const auto certain = field_with(2);
    CHECK(field_with(16).values == certain.values);
    CHECK(volume(certain) < volume(field_with(0.25f)));
    CHECK(volume(field_with(0.25f)) < volume(field_with(0)));
}
