#include "core/mesh/keep_apart.h"

#include <doctest/doctest.h>

#include "core/mesh/self_intersections.h"
#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

namespace {

/// Two unit spheres with a gap between them; the first one's vertices come first.
Mesh two_spheres(double gap) { return shapes::together(icosphere(3), icosphere(3, 1.0, {2 + gap, 0, 0})); }

std::size_t nearest_to(const Mesh& mesh, const Vec3& point) {
    std::size_t nearest = 0;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        if ((mesh.vertices[v] - point).norm() < (mesh.vertices[nearest] - point).norm()) nearest = v;
    return nearest;
}

}  // namespace

TEST_CASE("keep_apart: a corner that went through another piece goes back, what met nothing stays where it went") {
    Mesh mesh = two_spheres(0.05);
    REQUIRE(self_intersections(mesh).empty());
    const std::vector<Vec3> before = mesh.vertices;
    const std::size_t towards = nearest_to(mesh, {1, 0, 0}), away = nearest_to(mesh, {-1, 0, 0});
    mesh.vertices[towards] += Vec3(0.2, 0, 0);
    mesh.vertices[away] -= Vec3(0.2, 0, 0);
    REQUIRE(!self_intersections(mesh).empty());
    keep_apart(mesh, before);
    CHECK(self_intersections(mesh).empty());
    CHECK(mesh.vertices[towards] == before[towards]);
    CHECK(mesh.vertices[away] == before[away] - Vec3(0.2, 0, 0));
}

TEST_CASE("keep_apart: whoever is met by what goes back goes back as well") {
    // The second sphere moved into where the first one was, which moved away: alone the second would be free to.
    Mesh mesh = two_spheres(0.05);
    const std::vector<Vec3> before = mesh.vertices;
    const std::size_t n = mesh.vertices.size() / 2;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) mesh.vertices[v].x() -= v < n ? 0.1 : 0.2;
    REQUIRE(!self_intersections(mesh).empty());
    keep_apart(mesh, before);
    CHECK(self_intersections(mesh).empty());
}

TEST_CASE("keep_apart: what met before may move on, but to meet no others") {
    Mesh mesh = two_spheres(-0.05);
    const std::vector<Vec3> before = mesh.vertices;
    REQUIRE(!self_intersections(mesh).empty());
    keep_apart(mesh, before);
    CHECK(mesh.vertices == before);
    const std::size_t n = mesh.vertices.size() / 2;
    for (std::size_t v = n; v < mesh.vertices.size(); ++v) mesh.vertices[v].x() += 0.1;
    keep_apart(mesh, before);
    CHECK(self_intersections(mesh).empty());
    CHECK(mesh.vertices[n] == before[n] + Vec3(0.1, 0, 0));
}

TEST_CASE("keep_apart: ends where faces that did not move meet only by the rounding of a larger extent") {
    Mesh mesh = two_spheres(1e-6);
    REQUIRE(self_intersections(mesh).empty());
    const std::vector<Vec3> before = mesh.vertices;
    const std::size_t away = nearest_to(mesh, {-1, 0, 0});
    mesh.vertices[away] -= Vec3(1000, 0, 0);
    REQUIRE(!self_intersections(mesh).empty());
    keep_apart(mesh, before);
    CHECK(mesh.vertices[away] == before[away] - Vec3(1000, 0, 0));
}
