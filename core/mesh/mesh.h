#pragma once
#include <span>
#include <vector>

#include "core/types.h"

namespace anyrate {

/// An indexed triangle mesh, the plain form in which surfaces travel between the parts.
/// Triangles are counter-clockwise seen from outside; vertices are in world units.
struct Mesh {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    std::vector<Rgb8> colours;  ///< empty, or one per vertex

    int n_vertices() const { return static_cast<int>(vertices.size()); }
    int n_faces() const { return static_cast<int>(triangles.size()); }
};

}  // namespace anyrate
