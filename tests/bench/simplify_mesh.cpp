// Simplifies a mesh by quadric error (core/mesh/decimate.h): the other route to a vertex count, "reconstruct finely,
// then simplify", that the prefixes of a log are compared with.
//
// usage: simplify_mesh MESH -o OUT --vertices N
// prints {"vertices": of OUT, "faces": ...}
#include "core/mesh/decimate.h"
#include "core/mesh/mesh_io.h"
#include "tests/bench/tool.h"

int main(int argc, char** argv) {
    CLI::App app("Simplifies a mesh by quadric error.");
    std::string input, output;
    int n_vertices = 0;
    app.add_option("MESH", input, "closed mesh (.ply or .obj)")->required();
    app.add_option("-o,--output", output, "mesh to write")->required();
    app.add_option("--vertices", n_vertices, "that are left")->required()->check(CLI::PositiveNumber);
    return anyrate::bench::run_tool(app, argc, argv, [&]() -> anyrate::bench::Json {
        const anyrate::Mesh mesh = anyrate::decimate(anyrate::read_mesh(input), n_vertices);
        anyrate::write_mesh(mesh, output);
        return {{"vertices", mesh.n_vertices()}, {"faces", mesh.n_faces()}};
    });
}
