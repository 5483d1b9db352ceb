#pragma once
#include <span>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// A surface that somebody else owns: vertices in world units, triangles as in Mesh.
struct SurfaceView {
    std::span<const Vec3> vertices;
    std::span<const Triangle> triangles;

    SurfaceView(std::span<const Vec3> v, std::span<const Triangle> t) : vertices(v), triangles(t) {}
    SurfaceView(const Mesh& mesh) : vertices(mesh.vertices), triangles(mesh.triangles) {}  // NOLINT: a view of a mesh

    int n_vertices() const { return static_cast<int>(vertices.size()); }
    int n_faces() const { return static_cast<int>(triangles.size()); }
};

/// For every vertex its faces and its neighbours, both in ascending order: sums over a one-ring are taken in this
/// order, so that they do not depend on the number of threads.
class OneRings {
public:
    explicit OneRings(const SurfaceView& surface);

    std::span<const std::int32_t> faces(std::int32_t vertex) const { return row(face_begin_, faces_, vertex); }
    std::span<const std::int32_t> neighbours(std::int32_t vertex) const {
        return row(neighbour_begin_, neighbours_, vertex);
    }
    int valence(std::int32_t vertex) const { return static_cast<int>(neighbours(vertex).size()); }

private:
    static std::span<const std::int32_t> row(const std::vector<std::int32_t>& begin,
                                             const std::vector<std::int32_t>& entries, std::int32_t vertex) {
        const auto v = static_cast<std::size_t>(vertex);
        const auto first = static_cast<std::size_t>(begin[v]);
        return {entries.data() + first, static_cast<std::size_t>(begin[v + 1]) - first};
    }

    std::vector<std::int32_t> face_begin_, faces_, neighbour_begin_, neighbours_;
};

/// Outward unit normals, area-weighted over the one-ring; a vertex without area gets a zero vector.
std::vector<Vec3> vertex_normals(const SurfaceView& surface, const OneRings& rings);

/// The faces of some vertices' one-rings, ascending, each once.
std::vector<std::int32_t> faces_around(const OneRings& rings, std::span<const std::int32_t> vertices);

/// Flags every neighbour of a flagged vertex as well.
/// @param flags  one a vertex
void grow_by_ring(std::span<char> flags, const OneRings& rings);

/// Mean edge length around each vertex, world units.
std::vector<double> mean_edge_lengths(const SurfaceView& surface, const OneRings& rings);

}  // namespace anyrate
