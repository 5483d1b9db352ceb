// Step 1 of the method alone: the coarse mesh before any photograph's colours have moved it (the paper's Fig. 4a).
//
// usage: coarse_mesh CAPTURE -o MESH [--cameras FILE] [--vertices N]
// prints {"vertices", "faces"}
#include "core/capture/load_capture.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/remesh.h"
#include "core/reconstruction/initial_mesh.h"
#include "tests/bench/tool.h"

int main(int argc, char** argv) {
    CLI::App app("Makes the coarse mesh of a capture.");
    std::string folder, output;
    anyrate::LoadOptions load;
    anyrate::RemeshOptions remesh;
    app.add_option("CAPTURE", folder, "folder or zip")->required();
    app.add_option("-o,--output", output, "mesh to write")->required();
    app.add_option("--cameras", load.cameras_file, "name of the camera file")->capture_default_str();
    app.add_option("--vertices", remesh.n_vertices, "of the mesh")->capture_default_str();
    return anyrate::bench::run_tool(app, argc, argv, [&]() -> anyrate::bench::Json {
        const anyrate::Capture capture = anyrate::load_capture(folder, load);
        const anyrate::PhotoImages images = anyrate::make_photo_images(capture);
        const auto unheard = [](const anyrate::Progress&) {};
        const anyrate::Mesh mesh = anyrate::remesh_isotropic(
            anyrate::initial_surface(anyrate::visual_hull(capture, anyrate::hull_options(images)), images, unheard)
                .mesh,
            remesh);
        anyrate::write_mesh(mesh, output);
        return {{"vertices", mesh.n_vertices()}, {"faces", mesh.n_faces()}};
    });
}
