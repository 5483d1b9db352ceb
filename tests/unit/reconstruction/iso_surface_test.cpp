#include "core/reconstruction/iso_surface.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/mesh/topology.h"

using namespace anyrate;

namespace {

constexpr double pi = 3.14159265358979323846;

// A cube of n nodes an axis from (-1, -1, -1) to (1, 1, 1); inner values from `value`, positive on the border.
template <class Value>
ScalarField field_of(int n, const Value& value) {
    ScalarField field{n, n, n, Vec3(-1, -1, -1), 2.0 / (n - 1), {}};
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const bool border = std::min({i, j, k}) == 0 || std::max({i, j, k}) == n - 1;
                const Vec3 point = field.origin + field.spacing * Vec3(i, j, k);
                field.values.push_back(border ? 1.0f : static_cast<float>(value(point)));
            }
    return field;
}

double area(const Mesh& mesh) {
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3& corner = mesh.vertices[static_cast<std::size_t>(a)];
        sum += 0.5 * (mesh.vertices[static_cast<std::size_t>(b)] - corner)
                         .cross(mesh.vertices[static_cast<std::size_t>(c)] - corner)
                         .norm();
    }
    return sum;
}

double volume(const Mesh& mesh) {
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.triangles)
        sum += mesh.vertices[static_cast<std::size_t>(a)].dot(
                   mesh.vertices[static_cast<std::size_t>(b)].cross(mesh.vertices[static_cast<std::size_t>(c)])) /
               6.0;
    return sum;
}

}  // namespace

TEST_CASE("Iso-surface: of a random field it is a closed, consistently oriented manifold") {
    for (unsigned seed = 0; seed < 20; ++seed) {
        CAPTURE(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<float> value(-1.0f, 1.0f);
        const Mesh mesh = iso_surface(field_of(12, [&](const Vec3&) { return value(random); }));
        const Topology topology = measure_topology(mesh);
        CHECK(topology.is_closed_manifold());
        CHECK(topology.euler == topology.n_vertices - topology.n_edges + topology.n_faces);
        CHECK(volume(mesh) > 0.0);
    }
}

TEST_CASE("Iso-surface: ties, zeros and saddles on the edge of decision leave it a closed manifold") {
    for (unsigned seed = 0; seed < 20; ++seed) {
        CAPTURE(seed);
        std::mt19937 random(seed);
        const Mesh mesh = iso_surface(field_of(10, [&](const Vec3&) { return static_cast<int>(random() % 3) - 1; }));
        CHECK(measure_topology(mesh).is_closed_manifold());
    }
}

TEST_CASE("Iso-surface: each of the 256 sign patterns of a cell gives a closed manifold") {
    for (unsigned pattern = 0; pattern < 256; ++pattern) {
        CAPTURE(pattern);
        // Of the 4^3 nodes, the inner 2^3 are the corners of the cell in the middle.
        unsigned corner = 0;
        const Mesh mesh = iso_surface(field_of(4, [&](const Vec3&) { return pattern >> corner++ & 1 ? -1.0 : 1.0; }));
        if (pattern == 0)
            CHECK(mesh.n_vertices() == 0);
        else
            CHECK(measure_topology(mesh).is_closed_manifold());
    }
}

TEST_CASE("Iso-surface: volume and area of a ball converge with the square of the spacing") {
    double last_volume_error = 1.0, last_area_error = 1.0;
    for (const int n : {9, 17, 33, 65}) {
        const Mesh mesh = iso_surface(field_of(n, [](const Vec3& p) { return p.norm() - 0.8; }));
        CHECK(measure_topology(mesh).euler == 2);
        const double volume_error = std::abs(volume(mesh) / (4.0 / 3.0 * pi * std::pow(0.8, 3)) - 1);
        const double area_error = std::abs(area(mesh) / (4 * pi * std::pow(0.8, 2)) - 1);
        CHECK(volume_error < 0.35 * last_volume_error);
        CHECK(area_error < 0.35 * last_area_error);
        last_volume_error = volume_error;
        last_area_error = area_error;
    }
}

TEST_CASE("Iso-surface: of a torus it is one piece of genus 1") {
    const Mesh mesh = iso_surface(
        field_of(40, [](const Vec3& p) { return std::hypot(std::hypot(p.x(), p.y()) - 0.6, p.z()) - 0.2; }));
    CHECK(measure_topology(mesh).euler == 0);
    CHECK(measure_topology(mesh).n_components == 1);
}

TEST_CASE("Iso-surface: a linear field is met exactly") {
    const Vec3 normal = Vec3(3, -2, 5).normalized();
    const Mesh mesh = iso_surface(field_of(12, [&](const Vec3& p) { return normal.dot(p) - 0.1; }));
    int n_inner = 0;
    for (const Vec3& v : mesh.vertices) {
        // Next to the border the field is not linear.
        if (v.cwiseAbs().maxCoeff() > 1 - 2.0 / 11) continue;
        ++n_inner;
        CHECK(std::abs(normal.dot(v) - 0.1) < 0.01 * 2.0 / 11);
    }
    CHECK(n_inner > 50);
}

TEST_CASE("Iso-surface: a node that is exactly zero does not collapse a triangle") {
    // The plane x = 0 runs through a layer of nodes.
    const Mesh mesh = iso_surface(field_of(9, [](const Vec3& p) { return p.x(); }));
    CHECK(measure_topology(mesh).is_closed_manifold());
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3& corner = mesh.vertices[static_cast<std::size_t>(a)];
        CHECK((mesh.vertices[static_cast<std::size_t>(b)] - corner)
                  .cross(mesh.vertices[static_cast<std::size_t>(c)] - corner)
                  .norm() > 0.0);
    }
}

TEST_CASE("Iso-surface: without a negative node there is no surface") {
    CHECK(iso_surface(field_of(5, [](const Vec3&) { return 0.0; })).n_faces() == 0);
}
