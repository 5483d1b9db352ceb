#include "core/mesh/topology.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/mesh/disjoint_sets.h"
#include "core/mesh/edges.h"

namespace anyrate {
namespace {

void count_edges(const Mesh& mesh, const EdgeList& edges, Topology& count) {
    count.n_edges = edges.n_edges();
    for (int e = 0; e < edges.n_edges(); ++e) {
        const auto run = edges.edge(e);
        const bool is_loop = origin(mesh, run[0]) == target(mesh, run[0]);  // of a triangle that names a vertex twice
        if (is_loop || run.size() > 2)
            ++count.n_nonmanifold_edges;
        else if (run.size() == 1)
            ++count.n_boundary_edges;
        else if (origin(mesh, run[0]) == origin(mesh, run[1]))
            ++count.n_inconsistent_edges;
    }
}

/// The corner of the halfedge's face at vertex v, one of the halfedge's ends.
std::int32_t corner_at(const Mesh& mesh, std::int32_t halfedge, std::int32_t v) {
    return origin(mesh, halfedge) == v ? halfedge : next_halfedge(halfedge);
}

/// A fan is a set of corners of one vertex that hang together across edges; a manifold vertex has one.
int count_nonmanifold_vertices(const Mesh& mesh, const EdgeList& edges) {
    DisjointSets fans(3 * mesh.triangles.size());
    for (int e = 0; e < edges.n_edges(); ++e) {
        const auto run = edges.edge(e);
        for (std::size_t i = 1; i < run.size(); ++i)
            for (const std::int32_t v : {origin(mesh, run[0]), target(mesh, run[0])})
                fans.unite(corner_at(mesh, run[0], v), corner_at(mesh, run[i], v));
    }
    std::vector<int> n_fans(mesh.n_vertices(), 0);
    for (std::int32_t corner = 0; corner < 3 * mesh.n_faces(); ++corner)
        if (fans.find(corner) == corner) ++n_fans[origin(mesh, corner)];
    int n_bad = 0;
    for (const int n : n_fans) n_bad += n != 1;
    return n_bad;
}

DisjointSets vertex_components(const Mesh& mesh) {
    DisjointSets pieces(mesh.vertices.size());
    for (const Triangle& t : mesh.triangles) {
        pieces.unite(t[0], t[1]);
        pieces.unite(t[0], t[2]);
    }
    return pieces;
}

int count_components(const Mesh& mesh) {
    DisjointSets pieces = vertex_components(mesh);
    std::vector<bool> counted(mesh.vertices.size(), false);
    int n = 0;
    for (const Triangle& t : mesh.triangles) {
        const std::int32_t piece = pieces.find(t[0]);
        n += !counted[piece];
        counted[piece] = true;
    }
    return n;
}

/// The faces of the kept vertices, all renumbered in order.
Mesh keep_vertices(const Mesh& mesh, const std::vector<bool>& kept) {
    Mesh part;
    std::vector<std::int32_t> number(mesh.vertices.size(), -1);
    for (int v = 0; v < mesh.n_vertices(); ++v) {
        if (!kept[v]) continue;
        number[v] = part.n_vertices();
        part.vertices.push_back(mesh.vertices[v]);
        if (!mesh.colours.empty()) part.colours.push_back(mesh.colours[v]);
    }
    for (const Triangle& t : mesh.triangles)
        if (kept[t[0]]) part.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    return part;
}

}  // namespace

Topology measure_topology(const Mesh& mesh) {
    const EdgeList edges = list_edges(mesh);
    Topology count;
    count.n_vertices = mesh.n_vertices();
    count.n_faces = mesh.n_faces();
    count_edges(mesh, edges, count);
    count.n_nonmanifold_vertices = count_nonmanifold_vertices(mesh, edges);
    count.n_components = count_components(mesh);
    count.euler = count.n_vertices - count.n_edges + count.n_faces;
    return count;
}

Mesh largest_component(const Mesh& mesh) {
    if (mesh.triangles.empty()) return mesh;
    DisjointSets pieces = vertex_components(mesh);
    std::vector<double> volume(mesh.vertices.size(), 0.0);
    for (const Triangle& t : mesh.triangles) {
        // Seen from a vertex of the piece itself, so that a far origin costs no digits.
        const std::int32_t piece = pieces.find(t[0]);
        const Vec3& apex = mesh.vertices[piece];
        const Vec3 a = mesh.vertices[t[0]] - apex, b = mesh.vertices[t[1]] - apex, c = mesh.vertices[t[2]] - apex;
        volume[piece] += a.cross(b).dot(c) / 6;
    }
    std::int32_t largest = pieces.find(mesh.triangles[0][0]);
    for (int v = 0; v < mesh.n_vertices(); ++v)
        if (std::abs(volume[v]) > std::abs(volume[largest])) largest = v;
    std::vector<bool> kept(mesh.vertices.size());
    for (int v = 0; v < mesh.n_vertices(); ++v) kept[v] = pieces.find(v) == largest;
    return keep_vertices(mesh, kept);
}

}  // namespace anyrate
