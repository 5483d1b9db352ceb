#include "core/reconstruction/untangle.h"

#include <algorithm>
#include <vector>

#include "core/mesh/self_intersections.h"
#include "core/reconstruction/fairing.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {
namespace {

constexpr int most_rounds = 4;  ///< what four do not straighten, more do not

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// The corners of all faces that meet another than in what they share, ascending.
std::vector<std::int32_t> tangled_vertices(const Mesh& mesh) {
    std::vector<std::int32_t> vertices;
    for (const auto& [f, g] : self_intersections(mesh))
        for (const std::int32_t face : {f, g})
            vertices.insert(vertices.end(), mesh.triangles[at(face)].begin(), mesh.triangles[at(face)].end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

}  // namespace

bool untangle(Mesh& mesh) {
    const OneRings rings(mesh);
    for (int round = 0; round < most_rounds; ++round) {
        const std::vector<std::int32_t> tangled = tangled_vertices(mesh);
        if (tangled.empty()) return true;
        std::vector<char> movable(mesh.vertices.size(), 0);
        for (const std::int32_t v : tangled) {
            movable[at(v)] = 1;
            for (const std::int32_t w : rings.neighbours(v)) movable[at(w)] = 1;
        }
        stretch(mesh, movable);
    }
    return tangled_vertices(mesh).empty();
}

}  // namespace anyrate
