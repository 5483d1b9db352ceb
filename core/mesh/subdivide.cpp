#include "core/mesh/subdivide.h"

#include "core/mesh/edges.h"
#include "core/mesh/normals.h"

namespace anyrate {

Mesh subdivide(const Mesh& mesh) {
    const std::vector<Vec3> normals = vertex_normals(mesh);
    const EdgeList edges = list_edges(mesh);
    Mesh fine{.vertices = mesh.vertices, .triangles = {}, .colours = {}};
    std::vector<std::int32_t> middle(3 * mesh.triangles.size());  // of every halfedge
    for (int e = 0; e < edges.n_edges(); ++e) {
        const std::int32_t p = origin(mesh, edges.edge(e).front()), q = target(mesh, edges.edge(e).front());
        const Vec3 along = mesh.vertices[q] - mesh.vertices[p];
        const Vec3 bulge = along.dot(normals[p]) * normals[p] - along.dot(normals[q]) * normals[q];
        for (const std::int32_t h : edges.edge(e)) middle[h] = fine.n_vertices();
        fine.vertices.push_back(0.5 * (mesh.vertices[p] + mesh.vertices[q]) - 0.125 * bulge);
    }
    fine.triangles.reserve(4 * mesh.triangles.size());
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        const auto [a, b, c] = mesh.triangles[f];
        const std::int32_t ab = middle[3 * f], bc = middle[3 * f + 1], ca = middle[3 * f + 2];
        fine.triangles.insert(fine.triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    return fine;
}

}  // namespace anyrate
