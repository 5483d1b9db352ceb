#include "core/simulation/simulate.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "core/capture/load_capture.h"
#include "core/mesh/mesh_io.h"
#include "server/cli/commands.h"

namespace anyrate {
namespace {

struct SimulateCommand {
    std::filesystem::path mesh;
    std::string scene;
    std::filesystem::path capture;
    SimulateOptions options;
};

int simulate(const SimulateCommand& request) {
    const Simulation simulation = request.mesh.empty() ? simulate_scene(request.scene, request.options)
                                                       : simulate_mesh(read_mesh(request.mesh), request.options);
    save_capture(simulation.capture, request.capture);
    write_mesh(simulation.ground_truth, request.capture / "gt.ply");
    std::fprintf(stderr, "%s: %zu views of %dx%d pixels; the true surface is gt.ply\n", request.capture.c_str(),
                 simulation.capture.views.size(), request.options.width, request.options.height);
    return 0;
}

}  // namespace

void add_simulate(CLI::App& app, Command& command) {
    auto request = std::make_shared<SimulateCommand>();
    CLI::App* sub = app.add_subcommand("simulate", "render a capture of a known surface");
    auto* surface = sub->add_option_group("surface", "what is photographed");
    surface->add_option("--scene", request->scene, "a built-in scene")->check(CLI::IsMember(scene_names()));
    surface->add_option("--mesh", request->mesh, "a closed mesh (.ply or .obj); it gets a procedural texture");
    surface->require_option(1);
    sub->add_option("-o,--output", request->capture, "folder of the capture to write")->required();
    sub->add_option("--views", request->options.n_views, "number of cameras")
        ->check(CLI::Range(3, 1000))
        ->capture_default_str();
    sub->add_option("--width", request->options.width, "of an image, pixels")
        ->check(CLI::Range(16, 8192))
        ->capture_default_str();
    sub->add_option("--height", request->options.height, "of an image, pixels")
        ->check(CLI::Range(16, 8192))
        ->capture_default_str();
    sub->add_option("--noise", request->options.noise, "standard deviation of the sensor noise, 8-bit levels")
        ->check(CLI::Range(0.0, 255.0))
        ->capture_default_str();
    sub->add_option("--seed", request->options.seed, "of the noise")->capture_default_str();
    sub->callback([request, &command] { command = [request] { return simulate(*request); }; });
}

}  // namespace anyrate
