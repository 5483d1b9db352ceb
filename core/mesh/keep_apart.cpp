#include "core/mesh/keep_apart.h"

#include <algorithm>
#include <iterator>

#include "core/mesh/self_intersections.h"

namespace anyrate {

void keep_apart(Mesh& mesh, std::span<const Vec3> before) {
    auto meeting = self_intersections(mesh);
    if (meeting.empty()) return;
    const auto met = self_intersections(Mesh{{before.begin(), before.end()}, mesh.triangles, {}});
    for (;;) {
        decltype(meeting) come_to_meet;
        std::ranges::set_difference(meeting, met, std::back_inserter(come_to_meet));
        if (come_to_meet.empty()) return;
        for (const auto& [f, g] : come_to_meet)  // one of them has moved, or they would have met before
            for (const std::int32_t face : {f, g})
                for (const std::int32_t corner : mesh.triangles[static_cast<std::size_t>(face)]) {
                    const auto v = static_cast<std::size_t>(corner);
                    mesh.vertices[v] = before[v];
                }
        meeting = self_intersections(mesh);
    }
}

}  // namespace anyrate
