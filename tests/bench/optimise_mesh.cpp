// Step 2 of the method on a given mesh, at the photographs' own resolution. Started on the true surface it tells the
// bias of the measure: how far the images pull the surface away from where it should stay.
//
// usage: optimise_mesh MESH CAPTURE -o OUT [--cameras FILE]
// prints {"vertices", "psi_before", "psi_after"}
#include "core/capture/load_capture.h"
#include "core/mesh/mesh_io.h"
#include "core/reconstruction/optimise_surface.h"
#include "tests/bench/tool.h"

int main(int argc, char** argv) {
    CLI::App app("Optimises a mesh in the images of a capture.");
    std::string input, folder, output;
    anyrate::LoadOptions load;
    app.add_option("MESH", input, "closed mesh (.ply or .obj)")->required();
    app.add_option("CAPTURE", folder, "folder or zip")->required();
    app.add_option("-o,--output", output, "mesh to write")->required();
    app.add_option("--cameras", load.cameras_file, "name of the camera file")->capture_default_str();
    return anyrate::bench::run_tool(app, argc, argv, [&]() -> anyrate::bench::Json {
        anyrate::Mesh mesh = anyrate::read_mesh(input);
        const anyrate::Capture capture = anyrate::load_capture(folder, load);
        const anyrate::PhotoImages images = anyrate::make_photo_images(capture);
        anyrate::Silhouettes silhouettes(capture);
        const auto backend = anyrate::make_cpu_backend(images);
        const double before = anyrate::measure_surface(*backend, mesh);
        anyrate::optimise_surface(*backend, silhouettes, mesh.vertices, mesh.triangles, {}, {}, {.rounds = 5});
        anyrate::write_mesh(mesh, output);
        return {{"vertices", mesh.n_vertices()},
                {"psi_before", before},
                {"psi_after", anyrate::measure_surface(*backend, mesh)}};
    });
}
