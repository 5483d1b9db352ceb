#include "tests/unit/progressive/closed_manifold.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace anyrate::testing {

namespace {

using Edge = std::pair<std::int32_t, std::int32_t>;

std::string name(const Edge& edge) { return std::to_string(edge.first) + "-" + std::to_string(edge.second); }

/// Each directed edge and the half-edge on it; empty if an edge occurs twice.
std::map<Edge, std::int32_t> directed_edges(const RefinableMesh& mesh) {
    std::map<Edge, std::int32_t> edges;
    for (std::int32_t h = 0; h < 3 * mesh.n_faces(); ++h) {
        const Triangle& t = mesh.triangles()[static_cast<std::size_t>(h / 3)];
        const Edge edge{t[static_cast<std::size_t>(h % 3)], t[static_cast<std::size_t>((h + 1) % 3)]};
        if (edge.first == edge.second || !edges.emplace(edge, h).second) return {};
    }
    return edges;
}

/// Length of the cycle of neighbours around each vertex, found from the triangles; -1 where the faces form several
/// fans.
std::vector<int> fan_sizes(const RefinableMesh& mesh) {
    std::vector<std::map<std::int32_t, std::int32_t>> next(static_cast<std::size_t>(mesh.n_vertices()));
    for (const Triangle& t : mesh.triangles()) {
        for (std::size_t i = 0; i < 3; ++i) next[static_cast<std::size_t>(t[i])][t[(i + 1) % 3]] = t[(i + 2) % 3];
    }
    std::vector<int> sizes;
    for (const auto& around : next) {
        int size = 0;
        if (!around.empty()) {
            std::int32_t v = around.begin()->first;
            do {
                const auto found = around.find(v);
                if (found == around.end() || ++size > static_cast<int>(around.size())) break;
                v = found->second;
            } while (v != around.begin()->first);
        }
        sizes.push_back(size == static_cast<int>(around.size()) ? size : -1);
    }
    return sizes;
}

}  // namespace

std::string fault_of(const RefinableMesh& mesh) {
    const auto edges = directed_edges(mesh);
    if (edges.empty()) return "an edge occurs twice in one direction";
    for (const auto& [edge, h] : edges) {
        const auto opposite = edges.find({edge.second, edge.first});
        if (opposite == edges.end()) return "edge " + name(edge) + " has one side";
        if (mesh.twin(h) != opposite->second) return "edge " + name(edge) + " has a wrong twin";
    }
    const std::vector<int> sizes = fan_sizes(mesh);
    for (std::int32_t v = 0; v < mesh.n_vertices(); ++v) {
        if (sizes[static_cast<std::size_t>(v)] < 3)
            return "vertex " + std::to_string(v) + " has no single fan of 3 or more";
        if (sizes[static_cast<std::size_t>(v)] != mesh.valence(v))
            return "vertex " + std::to_string(v) + ": wrong valence";
    }
    const std::int32_t limit = 1 << mesh.grid().bits;
    const bool on_grid = std::ranges::all_of(mesh.positions(), [&](const GridPoint& p) {
        return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < limit && p.y < limit && p.z < limit;
    });
    return on_grid ? "" : "a vertex is off the grid";
}

int euler_characteristic(const RefinableMesh& mesh) {
    std::set<Edge> edges;
    for (const auto& [edge, h] : directed_edges(mesh)) edges.insert(std::minmax(edge.first, edge.second));
    return mesh.n_vertices() - static_cast<int>(edges.size()) + mesh.n_faces();
}

bool same_state(const RefinableMesh& a, const RefinableMesh& b) {
    if (a.n_faces() != b.n_faces() || a.state_hash() != b.state_hash()) return false;
    for (std::int32_t h = 0; h < 3 * a.n_faces(); ++h) {
        if (a.twin(h) != b.twin(h)) return false;
    }
    return std::ranges::equal(a.positions(), b.positions()) && std::ranges::equal(a.triangles(), b.triangles());
}

}  // namespace anyrate::testing
