#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "core/mesh/mesh_io.h"
#include "proto/log_reader.h"
#include "server/cli/budget_options.h"
#include "server/cli/commands.h"
#include "server/cli/output_name.h"
#include "server/cli/read_log.h"

namespace anyrate {
namespace {

struct DecodeOptions {
    std::filesystem::path model, mesh;
    BudgetOptions budget;
};

int decode(const DecodeOptions& options) {
    const Mesh mesh = decode_mesh(read_log(options.model), options.budget.budget());
    write_mesh(mesh, options.mesh);
    std::fprintf(stderr, "%s: %d vertices, %d faces\n", options.mesh.c_str(), mesh.n_vertices(), mesh.n_faces());
    return 0;
}

}  // namespace

void add_decode(CLI::App& app, Command& command) {
    auto options = std::make_shared<DecodeOptions>();
    CLI::App* sub = app.add_subcommand("decode", "write a model's mesh at a budget as a mesh file");
    sub->add_option("MODEL", options->model, "the log of a model (.arl)")->required();
    sub->add_option("-o,--output", options->mesh, "mesh file to write: .ply, .obj or .glb")
        ->required()
        ->check(mesh_file_name());
    options->budget.add_to(*sub);
    sub->callback([options, &command] { command = [options] { return decode(*options); }; });
}

}  // namespace anyrate
