#include "core/mesh/decimate_apart.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/mesh/decimate.h"
#include "core/mesh/self_intersections.h"

namespace anyrate {
namespace {

constexpr int most_rounds = 4;

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Flags the vertices that are left of the faces that meet, and their rings in the mesh that was simplified.
void keep_around(const std::vector<std::pair<std::int32_t, std::int32_t>>& meeting, const Decimated& coarse,
                 const Mesh& mesh, std::vector<char>& is_kept) {
    std::vector<char> meets(mesh.vertices.size(), 0);
    for (const auto& [f, g] : meeting)
        for (const std::int32_t face : {f, g})
            for (const std::int32_t v : coarse.mesh.triangles[at(face)]) meets[at(coarse.sources[at(v)])] = 1;
    for (const Triangle& t : mesh.triangles)
        if (std::ranges::any_of(t, [&](std::int32_t v) { return meets[at(v)] != 0; }))
            for (const std::int32_t v : t) is_kept[at(v)] = 1;
}

}  // namespace

Mesh decimate_apart(const Mesh& mesh, int n_vertices) {
    Decimated coarse = decimate_keeping(mesh, n_vertices, {});
    auto meeting = self_intersections(coarse.mesh);
    if (meeting.empty() || !self_intersections(mesh).empty()) return std::move(coarse.mesh);
    Mesh best = coarse.mesh;
    std::size_t fewest = meeting.size();
    std::vector<char> is_kept(mesh.vertices.size(), 0);
    for (int round = 0; round < most_rounds && fewest > 0; ++round) {
        keep_around(meeting, coarse, mesh, is_kept);
        coarse = decimate_keeping(mesh, n_vertices, is_kept);
        meeting = self_intersections(coarse.mesh);
        if (meeting.size() < fewest) {
            best = coarse.mesh;
            fewest = meeting.size();
        }
    }
    return best;
}

}  // namespace anyrate
