#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// The edges of an indexed mesh. Halfedge 3f+i runs along face f from its corner i to its corner i+1 (mod 3).
/// Any triangles will do, also ones that make no manifold.
struct EdgeList {
    std::vector<std::int32_t> halfedges;  ///< 3 n_faces of them, those along the same edge in one run
    std::vector<std::int32_t> begin;      ///< where each edge's run begins in `halfedges`, and the end of the last

    int n_edges() const { return static_cast<int>(begin.size()) - 1; }
    std::span<const std::int32_t> edge(int e) const {
        return {halfedges.data() + begin[e], halfedges.data() + begin[e + 1]};
    }
};
EdgeList list_edges(const Mesh& mesh);

/// The vertex a halfedge starts from, and the one it leads to.
inline std::int32_t origin(const Mesh& mesh, std::int32_t halfedge) {
    return mesh.triangles[halfedge / 3][halfedge % 3];
}
inline std::int32_t target(const Mesh& mesh, std::int32_t halfedge) {
    return mesh.triangles[halfedge / 3][(halfedge % 3 + 1) % 3];
}

/// The next halfedge around the same face.
inline std::int32_t next_halfedge(std::int32_t halfedge) { return halfedge % 3 == 2 ? halfedge - 2 : halfedge + 1; }

/// For every halfedge the one of the neighbouring face along the same edge. `mesh` is closed and manifold.
std::vector<std::int32_t> twin_halfedges(const Mesh& mesh);

}  // namespace anyrate
