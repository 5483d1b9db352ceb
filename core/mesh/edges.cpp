#include "core/mesh/edges.h"

#include <algorithm>
#include <numeric>

namespace anyrate {
namespace {

/// The halfedges in the order of their lower-numbered vertex: a counting sort, for the keys are dense.
std::vector<std::int32_t> by_lower_vertex(const Mesh& mesh, std::vector<std::int32_t>& begin) {
    const std::int32_t n_halfedges = 3 * mesh.n_faces();
    const auto lower = [&](std::int32_t h) { return std::min(origin(mesh, h), target(mesh, h)); };
    begin.assign(mesh.n_vertices() + 1, 0);
    for (std::int32_t h = 0; h < n_halfedges; ++h) ++begin[lower(h) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::int32_t> order(n_halfedges), fill(begin.begin(), begin.end() - 1);
    for (std::int32_t h = 0; h < n_halfedges; ++h) order[fill[lower(h)]++] = h;
    return order;
}

}  // namespace

EdgeList list_edges(const Mesh& mesh) {
    std::vector<std::int32_t> bucket;
    EdgeList list{.halfedges = by_lower_vertex(mesh, bucket), .begin = {}};
    list.begin.reserve(list.halfedges.size() / 2 + 1);
    const auto upper = [&](std::int32_t h) { return std::max(origin(mesh, h), target(mesh, h)); };
    for (int v = 0; v < mesh.n_vertices(); ++v) {
        const auto first = list.halfedges.begin() + bucket[v], last = list.halfedges.begin() + bucket[v + 1];
        std::sort(first, last,
                  [&](std::int32_t a, std::int32_t b) { return std::pair(upper(a), a) < std::pair(upper(b), b); });
        for (auto h = first; h != last; ++h)
            if (h == first || upper(*h) != upper(*(h - 1)))
                list.begin.push_back(static_cast<std::int32_t>(h - list.halfedges.begin()));
    }
    list.begin.push_back(static_cast<std::int32_t>(list.halfedges.size()));
    return list;
}

std::vector<std::int32_t> twin_halfedges(const Mesh& mesh) {
    std::vector<std::int32_t> twin(3 * mesh.triangles.size());
    const EdgeList edges = list_edges(mesh);
    for (int e = 0; e < edges.n_edges(); ++e) {
        const auto pair = edges.edge(e);
        twin[pair[0]] = pair[1];
        twin[pair[1]] = pair[0];
    }
    return twin;
}

}  // namespace anyrate
