#pragma once
// The halfedge mesh on which remeshing and simplification work. Heavy to compile: include it in .cpp files only.
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include <OpenMesh/Core/Geometry/EigenVectorT.hh>  // needs what the header above declares

#include "core/mesh/mesh.h"

namespace anyrate {

struct SurfaceTraits : OpenMesh::DefaultTraits {
    using Point = Vec3;
    using Normal = Vec3;
    VertexAttributes(OpenMesh::Attributes::Status);
    HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge | OpenMesh::Attributes::Status);
    EdgeAttributes(OpenMesh::Attributes::Status);
    FaceAttributes(OpenMesh::Attributes::Status);
};
struct Surface : OpenMesh::TriMesh_ArrayKernelT<SurfaceTraits> {
    /// Whether the surface is still manifold when the edge is collapsed: hides what a closed surface inherits, which
    /// asks the same, but a library that checks the type of a property at each access took 60 % of decimate() for it.
    bool is_collapse_ok(OpenMesh::HalfedgeHandle h);
};

/// Vertices and faces keep their numbers. `mesh` is closed and manifold.
Surface to_surface(const Mesh& mesh);

/// What is not marked as deleted, in order.
Mesh to_mesh(const Surface& surface);

}  // namespace anyrate
