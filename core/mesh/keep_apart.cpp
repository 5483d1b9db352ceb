#include "core/mesh/keep_apart.h"

#include "core/mesh/self_intersections.h"

namespace anyrate {

std::vector<std::pair<std::int32_t, std::int32_t>> keep_apart(Mesh& mesh, std::span<const Vec3> before) {
    for (;;) {
        auto meeting = self_intersections(mesh);
        bool any_moved = false;
        for (const auto& [f, g] : meeting)
            for (const std::int32_t face : {f, g})
                for (const std::int32_t corner : mesh.triangles[static_cast<std::size_t>(face)]) {
                    const auto v = static_cast<std::size_t>(corner);
                    any_moved = any_moved || mesh.vertices[v] != before[v];
                    mesh.vertices[v] = before[v];
                }
        if (!any_moved) return meeting;
    }
}

}  // namespace anyrate
