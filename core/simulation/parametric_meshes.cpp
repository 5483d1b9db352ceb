#include "core/simulation/parametric_meshes.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>

namespace anyrate {
namespace {

Mesh icosahedron() {
    const double phi = std::numbers::phi;
    Mesh mesh;
    mesh.vertices = {{-1, phi, 0},  {1, phi, 0},  {-1, -phi, 0}, {1, -phi, 0}, {0, -1, phi},  {0, 1, phi},
                     {0, -1, -phi}, {0, 1, -phi}, {phi, 0, -1},  {phi, 0, 1},  {-phi, 0, -1}, {-phi, 0, 1}};
    mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    return mesh;
}

/// One triangle becomes four; both triangles of an edge get the same new vertex, its midpoint.
void split_in_four(Mesh& mesh) {
    std::unordered_map<std::uint64_t, std::int32_t> midpoint_of_edge;
    const auto midpoint = [&](std::int32_t a, std::int32_t b) {
        const auto [low, high] = std::minmax(a, b);
        const auto key = (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint64_t>(high);
        const auto [entry, is_new] = midpoint_of_edge.try_emplace(key, mesh.n_vertices());
        if (is_new) mesh.vertices.push_back(0.5 * (mesh.vertices[low] + mesh.vertices[high]));
        return entry->second;
    };
    std::vector<Triangle> finer;
    finer.reserve(4 * mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        const std::int32_t ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
        finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
}

}  // namespace

Mesh icosphere(int subdivisions, double radius, const Vec3& centre) {
    Mesh mesh = icosahedron();
    for (int level = 0; level < subdivisions; ++level) {
        split_in_four(mesh);
        for (Vec3& vertex : mesh.vertices) vertex.normalize();
    }
    for (Vec3& vertex : mesh.vertices) vertex = centre + radius * vertex.normalized();
    return mesh;
}

Mesh torus(double major_radius, double minor_radius, int n_around, int n_across) {
    assert(n_around >= 3 && n_across >= 3 && minor_radius < major_radius);
    Mesh mesh;
    for (int i = 0; i < n_around; ++i) {
        const double u = 2 * std::numbers::pi * i / n_around;
        for (int j = 0; j < n_across; ++j) {
            const double v = 2 * std::numbers::pi * j / n_across;
            const double r = major_radius + minor_radius * std::cos(v);
            mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), minor_radius * std::sin(v));
        }
    }
    const auto index = [&](int i, int j) { return (i % n_around) * n_across + j % n_across; };
    for (int i = 0; i < n_around; ++i) {
        for (int j = 0; j < n_across; ++j) {
            const std::int32_t a = index(i, j), b = index(i + 1, j), c = index(i + 1, j + 1), d = index(i, j + 1);
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
        }
    }
    return mesh;
}

}  // namespace anyrate
