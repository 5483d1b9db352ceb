// What can be said of a mesh without a reference: whether it is a closed manifold, its pieces and genus, and how many
// pairs of its faces meet where they should not.
//
// usage: mesh_report MESH
// prints {"vertices", "faces", "components", "closed_manifold", "boundary_edges", "nonmanifold_edges", "genus": of all
//         components together, null if the mesh is not closed, "self_intersections": pairs of faces}
#include "core/mesh/mesh_io.h"
#include "core/mesh/self_intersections.h"
#include "core/mesh/topology.h"
#include "tests/bench/tool.h"

int main(int argc, char** argv) {
    CLI::App app("Tells a mesh's topology and self-intersections.");
    std::string input;
    app.add_option("MESH", input, "mesh (.ply or .obj)")->required();
    return anyrate::bench::run_tool(app, argc, argv, [&]() -> anyrate::bench::Json {
        const anyrate::Mesh mesh = anyrate::read_mesh(input);
        const anyrate::Topology topology = anyrate::measure_topology(mesh);
        anyrate::bench::Json genus;
        if (topology.is_closed_manifold()) genus = topology.n_components - topology.euler / 2;
        return {{"vertices", topology.n_vertices},
                {"faces", topology.n_faces},
                {"components", topology.n_components},
                {"closed_manifold", topology.is_closed_manifold()},
                {"boundary_edges", topology.n_boundary_edges},
                {"nonmanifold_edges", topology.n_nonmanifold_edges},
                {"genus", genus},
                {"self_intersections", anyrate::self_intersections(mesh).size()}};
    });
}
