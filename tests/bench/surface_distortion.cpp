// Psi (Nghiem et al., Eq. 10) of any mesh in the images of a capture: one yardstick for every method, and for the true
// surface, whose Psi is what noise and interpolation alone leave (the noise floor).
//
// usage: surface_distortion MESH CAPTURE [--cameras FILE] [--samples-per-px C] [--sampling adaptive|uniform]
// prints {"vertices", "psi": squared 8-bit colour units, "samples": with evidence, counted by weight}
#include <map>

#include "core/capture/load_capture.h"
#include "core/mesh/mesh_io.h"
#include "core/reconstruction/photo_backend.h"
#include "tests/bench/tool.h"

int main(int argc, char** argv) {
    CLI::App app("Measures Psi of a mesh in the images of a capture.");
    std::string input, folder;
    anyrate::LoadOptions load;
    double samples_per_px = 1.0;
    anyrate::Sampling sampling = anyrate::Sampling::adaptive;
    app.add_option("MESH", input, "closed mesh (.ply or .obj)")->required();
    app.add_option("CAPTURE", folder, "folder or zip")->required();
    app.add_option("--cameras", load.cameras_file, "name of the camera file")->capture_default_str();
    app.add_option("--samples-per-px", samples_per_px, "C of Eq. 7")->capture_default_str();
    app.add_option("--sampling", sampling, "adaptive or uniform")
        ->transform(CLI::CheckedTransformer(std::map<std::string, anyrate::Sampling>{
            {"adaptive", anyrate::Sampling::adaptive}, {"uniform", anyrate::Sampling::uniform}}));
    return anyrate::bench::run_tool(app, argc, argv, [&]() -> anyrate::bench::Json {
        const anyrate::Mesh mesh = anyrate::read_mesh(input);
        const anyrate::PhotoImages images = anyrate::make_photo_images(anyrate::load_capture(folder, load), 1);
        const auto backend = anyrate::make_cpu_backend(images, sampling);
        backend->set_surface(mesh, 0, samples_per_px);
        const auto triangles = backend->distortions(anyrate::whole_surface(mesh));
        double n_samples = 0;
        for (const anyrate::TriangleDistortion& triangle : triangles) n_samples += triangle.n_samples;
        return {
            {"vertices", mesh.n_vertices()}, {"psi", anyrate::surface_distortion(triangles)}, {"samples", n_samples}};
    });
}
