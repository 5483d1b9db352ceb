#include "core/mesh/compare.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/capture/load_capture.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/topology.h"
#include "server/cli/commands.h"
#include "server/cli/sight.h"

namespace anyrate {
namespace {

using Json = nlohmann::ordered_json;

constexpr int min_views_of_seen = 2;  // fewer give no evidence (Nghiem et al., Eq. 5)

struct CompareCommand {
    std::filesystem::path mesh, reference;
    std::optional<std::filesystem::path> capture;
    bool json = false;
};

struct Comparison {
    SurfaceDistance all;
    std::optional<SurfaceDistance> seen;  ///< where at least two cameras of the capture see the reference
    Topology topology;
};

Comparison compare(const CompareCommand& request) {
    const Mesh mesh = read_mesh(request.mesh), reference = read_mesh(request.reference);
    Comparison result;
    result.all = compare_surfaces(mesh, reference);
    result.topology = measure_topology(mesh);
    if (request.capture) {
        const Sight sight(load_capture(*request.capture), reference);
        result.seen = compare_surfaces(mesh, reference,
                                       [&](const Vec3& point) { return sight.n_views_of(point) >= min_views_of_seen; });
    }
    return result;
}

Json distance_json(const SurfaceDistance& distance) {
    return {{"accuracy", distance.accuracy},
            {"completeness", distance.completeness},
            {"mean", distance.mean},
            {"p90", distance.p90},
            {"hausdorff", distance.hausdorff}};
}

Json comparison_json(const Comparison& comparison) {
    const Topology& topology = comparison.topology;
    Json json = distance_json(comparison.all);
    json.update({{"vertices", topology.n_vertices},
                 {"faces", topology.n_faces},
                 {"pieces", topology.n_components},
                 {"boundary_edges", topology.n_boundary_edges},
                 {"nonmanifold_edges", topology.n_nonmanifold_edges},
                 {"euler", topology.euler},
                 {"closed_manifold", topology.is_closed_manifold()}});
    if (comparison.seen) json["seen"] = distance_json(*comparison.seen);
    return json;
}

void print_distance(const char* title, const SurfaceDistance& d) {
    std::printf("%-5s mean %.6f  accuracy %.6f  completeness %.6f  p90 %.6f  hausdorff %.6f\n", title, d.mean,
                d.accuracy, d.completeness, d.p90, d.hausdorff);
}

void print_comparison(const Comparison& comparison) {
    const Topology& topology = comparison.topology;
    std::printf("%d vertices, %d faces, %d pieces, %s\n", topology.n_vertices, topology.n_faces, topology.n_components,
                topology.is_closed_manifold() ? "closed manifold" : "not a closed manifold");
    std::printf("distances, in parts of the reference's diagonal:\n");
    print_distance("all", comparison.all);
    if (comparison.seen) print_distance("seen", *comparison.seen);
}

int run_compare(const CompareCommand& request) {
    const Comparison comparison = compare(request);
    if (request.json) {
        std::printf("%s\n", comparison_json(comparison).dump(1).c_str());
    } else {
        print_comparison(comparison);
    }
    return 0;
}

}  // namespace

void add_compare(CLI::App& app, Command& command) {
    auto request = std::make_shared<CompareCommand>();
    CLI::App* sub = app.add_subcommand("compare", "measure the distances between a mesh and a reference");
    sub->add_option("MESH", request->mesh, "mesh file (.ply or .obj)")->required();
    sub->add_option("REFERENCE", request->reference, "mesh file of the true surface")->required();
    sub->add_option("--capture", request->capture, "measure also what at least two cameras of this capture see");
    sub->add_flag("--json", request->json, "as JSON");
    sub->callback([request, &command] { command = [request] { return run_compare(*request); }; });
}

}  // namespace anyrate
