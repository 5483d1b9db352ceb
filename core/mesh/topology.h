#pragma once
#include "core/mesh/mesh.h"

namespace anyrate {

/// What can be counted of a mesh's connectivity. A closed orientable manifold of one piece has no boundary, bad or
/// inconsistent edge, no bad vertex, and genus = 1 - euler / 2.
struct Topology {
    int n_vertices = 0, n_edges = 0, n_faces = 0;
    int n_boundary_edges = 0;        ///< edges with one face
    int n_nonmanifold_edges = 0;     ///< edges with more than two faces
    int n_inconsistent_edges = 0;    ///< edges whose two faces run the same way along it
    int n_nonmanifold_vertices = 0;  ///< vertices whose faces form more than one fan; unused vertices count too
    int n_components = 0;
    int euler = 0;  ///< V - E + F

    bool is_closed_manifold() const {
        return n_faces > 0 && n_boundary_edges == 0 && n_nonmanifold_edges == 0 && n_inconsistent_edges == 0 &&
               n_nonmanifold_vertices == 0;
    }
};
Topology measure_topology(const Mesh& mesh);

/// The component of largest enclosed volume, vertices renumbered in order. `mesh` closed and manifold.
Mesh largest_component(const Mesh& mesh);

/// Cuts and caps handles whose shortest loop is shorter than `max_loop_length` (world units), as long as any is found:
/// noise of a field makes such handles; those of the object are longer and stay. Closed manifold in and out.
Mesh remove_small_handles(const Mesh& mesh, double max_loop_length);

}  // namespace anyrate
