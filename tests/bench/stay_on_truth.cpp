// Start on the truth and stay there: the true surface simplified to a few vertices, then step 2 of the method at the
// photographs' own resolution. How far it drifts is the bias of the measure; a surface without bias would stay.
// With --fitted the simplified surface is fitted to the true one as the base of a log is: facets of quadrics alone lie
// on one side of a surface that bends, and a surface that follows the images has to leave those.
//
// usage: stay_on_truth CAPTURE MESH [--vertices N] [--fitted] [--cameras FILE]
// prints {"vertices", "before": {"mean", "p90", "hausdorff"}, "after": {...}}: distances to MESH in parts of its
// diagonal, where at least two cameras see it
#include "core/capture/load_capture.h"
#include "core/mesh/coarse_fit.h"
#include "core/mesh/compare.h"
#include "core/mesh/decimate.h"
#include "core/mesh/mesh_io.h"
#include "core/reconstruction/optimise_surface.h"
#include "server/cli/sight.h"
#include "tests/bench/tool.h"

namespace {

anyrate::bench::Json to_json(const anyrate::SurfaceDistance& d) {
    return {{"mean", d.mean}, {"p90", d.p90}, {"hausdorff", d.hausdorff}};
}

anyrate::Mesh fitted(const anyrate::Mesh& truth, int n_vertices) {
    const anyrate::TrueSurface surface(truth, 200'000);
    anyrate::SurfaceMeter meter(surface);
    return anyrate::fit_coarse_mesh(truth, n_vertices, meter);
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Tells how far the images pull a surface away from the truth.");
    std::string folder, truth_file;
    int n_vertices = 5000;
    bool is_fitted = false;
    anyrate::LoadOptions load;
    app.add_option("CAPTURE", folder, "folder or zip")->required();
    app.add_option("MESH", truth_file, "the true surface, a closed mesh (.ply or .obj)")->required();
    app.add_option("--vertices", n_vertices, "of the simplified surface")->capture_default_str();
    app.add_flag("--fitted", is_fitted, "fit the simplified surface to the true one");
    app.add_option("--cameras", load.cameras_file, "name of the camera file")->capture_default_str();
    return anyrate::bench::run_tool(app, argc, argv, [&]() -> anyrate::bench::Json {
        const anyrate::Capture capture = anyrate::load_capture(folder, load);
        const anyrate::Mesh truth = anyrate::read_mesh(truth_file);
        const anyrate::Sight sight(capture, truth);
        const auto distance = [&](const anyrate::Mesh& mesh) {
            return to_json(anyrate::compare_surfaces(
                mesh, truth, [&](const anyrate::Vec3& point) { return sight.n_views_of(point) >= 2; }));
        };
        anyrate::Mesh mesh = is_fitted ? fitted(truth, n_vertices) : anyrate::decimate(truth, n_vertices);
        const anyrate::bench::Json before = distance(mesh);
        const anyrate::PhotoImages images = anyrate::make_photo_images(capture);
        anyrate::Silhouettes silhouettes(capture);
        const auto backend = anyrate::make_cpu_backend(images);
        // Sliding along the surface would undo the simplification: what remains is the drift along the normals.
        anyrate::optimise_surface(*backend, silhouettes, mesh.vertices, mesh.triangles, {}, {},
                                  {.rounds = 5, .tangential = 0});
        return {{"vertices", mesh.n_vertices()}, {"before", before}, {"after", distance(mesh)}};
    });
}
