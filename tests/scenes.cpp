#include "tests/scenes.h"

#include <array>
#include <map>

#include "core/simulation/simulate.h"

namespace anyrate {

Mesh cube_surface(int n) {
    Mesh mesh;
    std::map<std::array<int, 3>, std::int32_t> vertex_at;  // by position on the n x n x n lattice
    const auto vertex = [&](const std::array<int, 3>& cell) {
        const auto [entry, is_new] = vertex_at.try_emplace(cell, mesh.n_vertices());
        if (is_new) mesh.vertices.push_back(Vec3(cell[0], cell[1], cell[2]) * (2.0 / n) - Vec3::Ones());
        return entry->second;
    };
    for (int axis = 0; axis < 3; ++axis) {
        for (const int level : {0, n}) {
            // (axis, u, v) is a cyclic order: u x v points along the axis, outwards at its high end only.
            const int u = (axis + (level == n ? 1 : 2)) % 3, v = (axis + (level == n ? 2 : 1)) % 3;
            for (int i = 0; i < n; ++i) {
                for (int j = 0; j < n; ++j) {
                    const auto corner = [&](int di, int dj) {
                        std::array<int, 3> cell{};
                        cell[axis] = level;
                        cell[u] = i + di;
                        cell[v] = j + dj;
                        return vertex(cell);
                    };
                    const std::int32_t a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
                    mesh.triangles.push_back({a, b, c});
                    mesh.triangles.push_back({a, c, d});
                }
            }
        }
    }
    return mesh;
}

Capture sphere_capture(int n_views, int size) {
    return simulate_scene("sphere",
                          {.n_views = n_views, .width = size, .height = size * 3 / 4, .noise = 1.0, .supersampling = 2})
        .capture;
}

}  // namespace anyrate
