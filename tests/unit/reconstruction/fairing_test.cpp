#include "core/reconstruction/fairing.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/reconstruction/surface_view.h"
#include "core/simulation/parametric_meshes.h"

using namespace anyrate;

namespace {

std::vector<char> cap_of(const Mesh& mesh, double least_x) {
    std::vector<char> cap;
    for (const Vec3& v : mesh.vertices) cap.push_back(v.normalized().x() > least_x);
    return cap;
}

double farthest_from_sphere(const Mesh& mesh) {
    double farthest = 0;
    for (const Vec3& v : mesh.vertices) farthest = std::max(farthest, std::abs(v.norm() - 1));
    return farthest;
}

}  // namespace

TEST_CASE("Fairing: a dent in a sphere is closed by the curvature around it") {
    Mesh mesh = icosphere(4);
    const std::vector<char> cap = cap_of(mesh, 0.9);
    for (std::size_t v = 0; v < cap.size(); ++v)
        if (cap[v] != 0) mesh.vertices[v] *= 0.5;
    fair(mesh, cap, 1e-9);
    CHECK(farthest_from_sphere(mesh) < 0.01);
}

TEST_CASE("Fairing: what is not flagged stays, and a strong attachment holds the rest") {
    const Mesh before = icosphere(3);
    Mesh mesh = before;
    const std::vector<char> cap = cap_of(mesh, 0.8);
    for (std::size_t v = 0; v < cap.size(); ++v)
        if (cap[v] != 0) mesh.vertices[v] *= 0.9;
    const Mesh dented = mesh;
    fair(mesh, cap, 1e9);
    for (std::size_t v = 0; v < cap.size(); ++v) {
        if (cap[v] == 0) CHECK(mesh.vertices[v] == before.vertices[v]);
        CHECK((mesh.vertices[v] - dented.vertices[v]).norm() < 1e-6);
    }
}

TEST_CASE("Fairing: moving and turning the surface moves and turns the result") {
    Mesh mesh = icosphere(3);
    const std::vector<char> cap = cap_of(mesh, 0.7);
    for (std::size_t v = 0; v < cap.size(); ++v)
        if (cap[v] != 0) mesh.vertices[v] *= 0.8;
    Mesh moved = mesh;
    const auto turned = [](const Vec3& v) { return Vec3(v.y() + 5, v.z() - 3, v.x() + 1); };
    for (Vec3& v : moved.vertices) v = turned(v);
    fair(mesh, cap, 1e-3);
    fair(moved, cap, 1e-3);
    for (std::size_t v = 0; v < cap.size(); ++v) CHECK((moved.vertices[v] - turned(mesh.vertices[v])).norm() < 1e-9);
}

TEST_CASE("Fairing: a part that is stretched over a flat rim is flat, and the rest stays") {
    const Mesh before = icosphere(4);
    Mesh mesh = before;
    const std::vector<char> cap = cap_of(mesh, 0.6);
    const OneRings rings(mesh);
    for (std::int32_t v = 0; v < mesh.n_vertices(); ++v)  // what carries the cap is moved into a plane
        for (const std::int32_t w : rings.neighbours(v))
            if (cap[static_cast<std::size_t>(v)] == 0 && cap[static_cast<std::size_t>(w)] != 0)
                mesh.vertices[static_cast<std::size_t>(v)].x() = 0.6;
    const Mesh rimmed = mesh;
    stretch(mesh, cap);
    for (std::size_t v = 0; v < cap.size(); ++v) {
        if (cap[v] != 0)
            CHECK(mesh.vertices[v].x() == doctest::Approx(0.6).epsilon(1e-4));
        else
            CHECK(mesh.vertices[v] == rimmed.vertices[v]);
    }
}

TEST_CASE("Fairing: stretched without a rim, a surface still has a place") {
    Mesh mesh = icosphere(2);
    stretch(mesh, std::vector<char>(mesh.vertices.size(), 1));
    for (const Vec3& v : mesh.vertices) CHECK(v.norm() <= 1 + 1e-9);
}
