#pragma once
// The edits of a Surface that remeshing is made of. Each is refused, with false or nothing done, where it would break
// the manifold or fold the surface over. Heavy to compile: include it in .cpp files only.
#include <optional>

#include "core/mesh/surface.h"

namespace anyrate {

struct CollapseLimits {
    double max_length = 0;    ///< of the edges that the collapse makes
    double max_distance = 0;  ///< of the vanishing vertex to the triangles that cover for it: keeps fingers and tips
};

/// Moves the halfedge's origin into its target, if that keeps a closed manifold, the limits and all normals roughly.
/// Deleted elements stay until garbage_collection(). Returns the distance of the vanished vertex to the triangles that
/// cover for it, nullopt if refused.
std::optional<double> collapse(Surface& surface, OpenMesh::HalfedgeHandle h, const CollapseLimits& limits);

/// The same whatever it does to the shape: for edges so short that the triangles beside them are noise.
bool collapse_blindly(Surface& surface, OpenMesh::HalfedgeHandle h);

/// Flips the edge if that brings the four valences nearer to six, or keeps them and makes the edge locally Delaunay,
/// and the two triangles bend no more than before and stay well shaped.
bool flip_to_improve(Surface& surface, OpenMesh::EdgeHandle e);

/// Moves the vertex if no triangle around it turns or degenerates.
bool move(Surface& surface, OpenMesh::VertexHandle v, const Vec3& to);

/// The sum of the area vectors of the faces around a vertex, twice as long: its outward normal, not of unit length.
Vec3 ring_normal(const Surface& surface, OpenMesh::VertexHandle v);

double squared_length(const Surface& surface, OpenMesh::EdgeHandle e);

}  // namespace anyrate
