#include "core/mesh/keep_apart.h"

#include <algorithm>
#include <iterator>

#include "core/mesh/self_intersections.h"

namespace anyrate {

void keep_apart(Mesh& mesh, std::span<const Vec3> before) {
    auto meeting = self_intersections(mesh);
    if (meeting.empty()) return;
    const auto met = self_intersections(Mesh{{before.begin(), before.end()}, mesh.triangles, {}});
    for (;; meeting = self_intersections(mesh)) {
        decltype(meeting) come_to_meet;
        std::ranges::set_difference(meeting, met, std::back_inserter(come_to_meet));
        // Both of a pair may be where they were: what touches depends on the mesh's extent by a rounding.
        bool any_moved = false;
        for (const auto& [f, g] : come_to_meet)
            for (const std::int32_t face : {f, g})
                for (const std::int32_t corner : mesh.triangles[static_cast<std::size_t>(face)]) {
                    const auto v = static_cast<std::size_t>(corner);
                    any_moved = any_moved || mesh.vertices[v] != before[v];
                    mesh.vertices[v] = before[v];
                }
        if (!any_moved) return;
    }
}

}  // namespace anyrate
