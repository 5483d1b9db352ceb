// How well a mesh fills the masks of a capture: intersection over union of its rendered silhouette and each mask.
//
// usage: silhouette_iou MESH CAPTURE [--cameras FILE]
// prints {"mean", "min", "views": [one number a view]}
#include <algorithm>
#include <numeric>

#include "core/capture/load_capture.h"
#include "core/mesh/mesh_io.h"
#include "tests/bench/silhouette_overlap.h"
#include "tests/bench/tool.h"

int main(int argc, char** argv) {
    CLI::App app("Compares a mesh's silhouettes with the masks of a capture.");
    std::string input, folder;
    anyrate::LoadOptions load;
    app.add_option("MESH", input, "closed mesh (.ply or .obj)")->required();
    app.add_option("CAPTURE", folder, "folder or zip")->required();
    app.add_option("--cameras", load.cameras_file, "name of the camera file")->capture_default_str();
    return anyrate::bench::run_tool(app, argc, argv, [&]() -> anyrate::bench::Json {
        const anyrate::Mesh mesh = anyrate::read_mesh(input);
        const anyrate::Capture capture = anyrate::load_capture(folder, load);
        std::vector<double> overlaps;
        for (const anyrate::View& view : capture.views)
            overlaps.push_back(anyrate::bench::silhouette_overlap(mesh, view));
        const double sum = std::accumulate(overlaps.begin(), overlaps.end(), 0.0);
        return {{"mean", sum / static_cast<double>(overlaps.size())},
                {"min", *std::min_element(overlaps.begin(), overlaps.end())},
                {"views", overlaps}};
    });
}
