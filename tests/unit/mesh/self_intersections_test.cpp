#include "core/mesh/self_intersections.h"

#include <doctest/doctest.h>

#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

namespace {

/// Two triangles without a common vertex.
Mesh two(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
    return {.vertices = {a[0], a[1], a[2], b[0], b[1], b[2]}, .triangles = {{0, 1, 2}, {3, 4, 5}}, .colours = {}};
}

const std::array<Vec3, 3> floor_triangle = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)};

/// Faces of a sphere of radius 1 around the origin with a vertex on each side of the plane x = `x`.
int n_faces_across(const Mesh& mesh, double x) {
    int n = 0;
    for (const Triangle& t : mesh.triangles) {
        int n_beyond = 0;
        for (const auto v : t) n_beyond += mesh.vertices[static_cast<std::size_t>(v)].x() > x;
        n += n_beyond % 3 != 0;
    }
    return n;
}

}  // namespace

TEST_CASE("self_intersections: sphere and torus have none, wherever and however large they are") {
    CHECK(self_intersections(icosphere(4)).empty());
    CHECK(self_intersections(torus(2, 0.5, 90, 40)).empty());
    CHECK(self_intersections(icosphere(3, 1e-5, {1e-3, 0, 0})).empty());
    CHECK(self_intersections(icosphere(3, 2e4, {-1e6, 3, 9})).empty());
    CHECK(self_intersections({}).empty());
}

TEST_CASE("self_intersections: a triangle through another is one pair, smaller number first") {
    const auto pairs = self_intersections(two(floor_triangle, {Vec3(1, 1, -1), Vec3(1, 1, 1), Vec3(9, 9, 1)}));
    REQUIRE(pairs.size() == 1);
    CHECK(pairs[0] == std::pair<std::int32_t, std::int32_t>(0, 1));
}

TEST_CASE("self_intersections: a corner that touches counts, one just above does not") {
    CHECK(self_intersections(two(floor_triangle, {Vec3(1, 1, 0), Vec3(1, 1, 3), Vec3(2, 1, 3)})).size() == 1);
    CHECK(self_intersections(two(floor_triangle, {Vec3(1, 1, 1e-6), Vec3(1, 1, 3), Vec3(2, 1, 3)})).empty());
}

TEST_CASE("self_intersections: triangles of one plane meet if they overlap, not if they are beside each other") {
    CHECK(self_intersections(two(floor_triangle, {Vec3(1, 1, 0), Vec3(9, 1, 0), Vec3(1, 9, 0)})).size() == 1);
    CHECK(self_intersections(two(floor_triangle, {Vec3(0.5, 0.5, 0), Vec3(1, 0.5, 0), Vec3(0.5, 1, 0)})).size() == 1);
    CHECK(self_intersections(two(floor_triangle, {Vec3(-2, 1, 0), Vec3(9, 1, 0), Vec3(9, 1.5, 0)})).size() == 1);
    CHECK(self_intersections(two(floor_triangle, {Vec3(3, 3, 0), Vec3(4, 3, 0), Vec3(3, 4, 0)})).empty());
}

TEST_CASE("self_intersections: neighbours across an edge meet only if they are folded flat") {
    Mesh fold{
        .vertices = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, -2, 0}}, .triangles = {{0, 1, 2}, {1, 0, 3}}, .colours = {}};
    CHECK(self_intersections(fold).empty());
    fold.vertices[3] = {0, 1.9, 0.01};
    CHECK(self_intersections(fold).empty());
    fold.vertices[3] = {0, 1.9, 0};
    CHECK(self_intersections(fold).size() == 1);
}

TEST_CASE("self_intersections: neighbours around a vertex meet if one pierces the other") {
    Mesh fan{.vertices = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {3, 1, 1}, {1, 3, 1}},
             .triangles = {{0, 1, 2}, {0, 3, 4}},
             .colours = {}};
    CHECK(self_intersections(fan).empty());
    fan.vertices[4].z() = -1;
    CHECK(self_intersections(fan).size() == 1);
}

TEST_CASE("self_intersections: two spheres that overlap meet along one circle, in about as many faces as it crosses") {
    const Mesh sphere = icosphere(4);
    const auto pairs = self_intersections(shapes::together(sphere, shapes::translated(sphere, {1.0, 0.01, 0.003})));
    const int n_crossed = n_faces_across(sphere, 0.5);
    CHECK(static_cast<int>(pairs.size()) >= n_crossed);
    CHECK(static_cast<int>(pairs.size()) <= 4 * n_crossed);
    for (const auto& [a, b] : pairs) CHECK((a < sphere.n_faces() && b >= sphere.n_faces()));
    CHECK(self_intersections(shapes::together(sphere, shapes::translated(sphere, {2.001, 0, 0}))).empty());
}

TEST_CASE("self_intersections: one large face among many small ones is found") {
    Mesh mesh = icosphere(4);
    const auto n = static_cast<std::int32_t>(mesh.n_vertices());
    mesh.vertices.insert(mesh.vertices.end(), {Vec3(-9, -9, 0.013), Vec3(9, -9, 0.011), Vec3(0, 12, 0.017)});
    mesh.triangles.push_back({n, n + 1, n + 2});
    const auto pairs = self_intersections(mesh);
    CHECK(pairs.size() > 60);  // the equator of a sphere of 5,120 faces
    for (const auto& [a, b] : pairs) CHECK(b == mesh.n_faces() - 1);
}

TEST_CASE("self_intersections: faces without area are left out") {
    CHECK(self_intersections(two(floor_triangle, {Vec3(1, 1, -1), Vec3(1, 1, 0), Vec3(1, 1, 1)})).empty());
}
