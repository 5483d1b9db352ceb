#include "core/mesh/homology.h"

#include "core/mesh/edges.h"

namespace anyrate {
namespace {

/// Marks both halfedges of the edges of a spanning forest of the vertices, breadth first.
std::vector<bool> spanning_tree(const Mesh& mesh, const std::vector<std::int32_t>& twin) {
    std::vector<std::int32_t> outgoing(mesh.vertices.size(), -1);
    for (std::int32_t h = 0; h < 3 * mesh.n_faces(); ++h) outgoing[origin(mesh, h)] = h;
    std::vector<bool> in_tree(twin.size(), false), reached(mesh.vertices.size(), false);
    std::vector<std::int32_t> queue;
    for (std::int32_t root = 0; root < mesh.n_vertices(); ++root) {
        if (reached[root]) continue;
        reached[root] = true;
        queue.assign(1, root);
        for (std::size_t i = 0; i < queue.size(); ++i) {
            const std::int32_t first = outgoing[queue[i]];
            std::int32_t h = first;
            do {
                const std::int32_t v = target(mesh, h);
                if (!reached[v]) {
                    reached[v] = true;
                    in_tree[h] = in_tree[twin[h]] = true;
                    queue.push_back(v);
                }
                h = next_halfedge(twin[h]);
            } while (h != first);
        }
    }
    return in_tree;
}

/// The way from each face towards its root in a spanning forest of the faces, which crosses no edge of `in_tree`: the
/// halfedge of the face to cross, -1 at a root.
std::vector<std::int32_t> spanning_cotree(const Mesh& mesh, const std::vector<std::int32_t>& twin,
                                          const std::vector<bool>& in_tree) {
    constexpr std::int32_t unreached = -2, root_mark = -1;
    std::vector<std::int32_t> to_root(mesh.triangles.size(), unreached), queue;
    for (std::int32_t root = 0; root < mesh.n_faces(); ++root) {
        if (to_root[root] != unreached) continue;
        to_root[root] = root_mark;
        queue.assign(1, root);
        for (std::size_t i = 0; i < queue.size(); ++i)
            for (std::int32_t h = 3 * queue[i]; h < 3 * queue[i] + 3; ++h) {
                const std::int32_t face = twin[h] / 3;
                if (in_tree[h] || to_root[face] != unreached) continue;
                to_root[face] = twin[h];
                queue.push_back(face);
            }
    }
    return to_root;
}

}  // namespace

std::vector<std::uint64_t> homology_signatures(const Mesh& mesh, const std::vector<std::int32_t>& twin) {
    const std::vector<bool> in_tree = spanning_tree(mesh, twin);
    const std::vector<std::int32_t> to_root = spanning_cotree(mesh, twin, in_tree);
    std::vector<std::uint64_t> signature(twin.size(), 0);
    int n_loops = 0;
    for (std::int32_t h = 0; h < 3 * mesh.n_faces() && n_loops < 64; ++h) {
        const bool in_cotree = to_root[h / 3] == h || to_root[twin[h] / 3] == twin[h];
        if (h > twin[h] || in_tree[h] || in_cotree) continue;
        // An edge of neither tree closes one loop of faces: over the edge, and both ways back to the root.
        const std::uint64_t bit = std::uint64_t{1} << n_loops++;
        const auto cross = [&](std::int32_t crossed) {
            signature[crossed] ^= bit;
            signature[twin[crossed]] ^= bit;
        };
        cross(h);
        for (std::int32_t face : {h / 3, twin[h] / 3})
            for (; to_root[face] >= 0; face = twin[to_root[face]] / 3) cross(to_root[face]);
    }
    return signature;
}

}  // namespace anyrate
