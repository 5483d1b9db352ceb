#include "core/encoding/closed_surface.h"

#include <doctest/doctest.h>

#include <limits>
#include <string>

#include "core/error.h"
#include "core/simulation/parametric_meshes.h"

using namespace anyrate;

namespace {

/// What the refusal says; empty if there is none.
std::string refusal(const Mesh& mesh) {
    try {
        require_closed_surface(mesh, "mesh");
        return {};
    } catch (const InputError& error) {
        return error.what();
    }
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("Closed surface: a sphere and a torus are closed") {
    CHECK(refusal(icosphere(2)) == "");
    CHECK(refusal(torus(1, 0.3, 12, 8)) == "");
}

TEST_CASE("Closed surface: a hole is refused, and so is no surface at all") {
    Mesh mesh = icosphere(1);
    mesh.triangles.pop_back();
    CHECK(contains(refusal(mesh), "3 edges of one face"));
    CHECK(contains(refusal({}), "found none"));
}

TEST_CASE("Closed surface: two pieces are refused") {
    Mesh mesh = icosphere(1);
    const Mesh other = icosphere(1, 1.0, Vec3(5, 0, 0));
    const std::int32_t n = mesh.n_vertices();
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({a + n, b + n, c + n});
    CHECK(contains(refusal(mesh), "expected one piece, found 2"));
}

TEST_CASE("Closed surface: what is no manifold or not oriented is refused") {
    Mesh turned = icosphere(1);
    std::swap(turned.triangles[3][0], turned.triangles[3][1]);
    CHECK(contains(refusal(turned), "3 edges whose two faces are not oriented alike"));
    Mesh doubled = icosphere(1);
    doubled.triangles.push_back(doubled.triangles[3]);
    CHECK(contains(refusal(doubled), "3 edges of more than two faces"));
}

TEST_CASE("Closed surface: a coordinate that is no number is refused") {
    Mesh mesh = icosphere(1);
    mesh.vertices[7].y() = std::numeric_limits<double>::quiet_NaN();
    CHECK(contains(refusal(mesh), "vertex 7"));
}
