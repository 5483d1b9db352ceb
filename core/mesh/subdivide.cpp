#include "core/mesh/subdivide.h"

#include "core/mesh/edges.h"
#include "core/mesh/normals.h"

namespace anyrate {
namespace {

constexpr std::int32_t none = -1;

/// New vertices at the middles of the edges that `is_split` says, given their two ends.
/// @return of every halfedge its new vertex, or none
template <class IsSplit>
std::vector<std::int32_t> add_middles(Mesh& fine, const Mesh& mesh, const IsSplit& is_split) {
    const std::vector<Vec3> normals = vertex_normals(mesh);
    const EdgeList edges = list_edges(mesh);
    std::vector<std::int32_t> middle(3 * mesh.triangles.size(), none);
    for (int e = 0; e < edges.n_edges(); ++e) {
        const std::int32_t p = origin(mesh, edges.edge(e).front()), q = target(mesh, edges.edge(e).front());
        if (!is_split(p, q)) continue;
        const Vec3 along = mesh.vertices[q] - mesh.vertices[p];
        const Vec3 bulge = along.dot(normals[p]) * normals[p] - along.dot(normals[q]) * normals[q];
        for (const std::int32_t h : edges.edge(e)) middle[h] = fine.n_vertices();
        fine.vertices.push_back(0.5 * (mesh.vertices[p] + mesh.vertices[q]) - 0.125 * bulge);
    }
    return middle;
}

/// The parts of a face, of whose edges all, one or none have a new vertex.
void add_parts(std::vector<Triangle>& parts, const Triangle& face, const std::int32_t* middle) {
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        if (middle[i] == none || middle[j] != none || middle[k] != none) continue;
        parts.insert(parts.end(), {{face[i], middle[i], face[k]}, {middle[i], face[j], face[k]}});
        return;
    }
    const auto [a, b, c] = face;
    const std::int32_t ab = middle[0], bc = middle[1], ca = middle[2];
    if (ab == none)
        parts.push_back(face);
    else
        parts.insert(parts.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
}

template <class IsSplit>
Mesh with_split_edges(const Mesh& mesh, const IsSplit& is_split) {
    Mesh fine{.vertices = mesh.vertices, .triangles = {}, .colours = {}};
    const std::vector<std::int32_t> middle = add_middles(fine, mesh, is_split);
    fine.triangles.reserve(mesh.triangles.size() + 2 * (fine.vertices.size() - mesh.vertices.size()));
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        add_parts(fine.triangles, mesh.triangles[f], &middle[3 * f]);
    return fine;
}

}  // namespace

Mesh subdivide(const Mesh& mesh) {
    return with_split_edges(mesh, [](std::int32_t, std::int32_t) { return true; });
}

Mesh subdivide_where(const Mesh& mesh, std::span<const char> flags) {
    return with_split_edges(mesh, [&](std::int32_t p, std::int32_t q) { return flags[p] != 0 && flags[q] != 0; });
}

}  // namespace anyrate
