#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/mesh/mesh_io.h"
#include "proto/draco_glb.h"
#include "proto/log_reader.h"
#include "server/cli/budget_options.h"
#include "server/cli/commands.h"
#include "server/cli/output_name.h"
#include "server/cli/read_log.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

struct DecodeOptions {
    std::filesystem::path model, mesh;
    BudgetOptions budget;
    bool draco = false;
};

int decode(const DecodeOptions& options) {
    const std::vector<std::byte> log = read_log(options.model);
    const Mesh mesh = naming_log(options.model, [&] {
        warn_if_cut(read_layout(log), log.size(), options.model);
        return decode_mesh(log, options.budget.budget());
    });
    if (options.draco) {
        replace_file(options.mesh, encode_draco_glb(mesh));
    } else {
        write_mesh(mesh, options.mesh);
    }
    std::fprintf(stderr, "%s: %d vertices, %d faces\n", options.mesh.c_str(), mesh.n_vertices(), mesh.n_faces());
    return 0;
}

}  // namespace

void add_decode(CLI::App& app, Command& command) {
    auto options = std::make_shared<DecodeOptions>();
    CLI::App* sub = app.add_subcommand("decode", "write a model's mesh at a budget as a mesh file");
    sub->add_option("MODEL", options->model, "the log of a model (.arl); - is the standard input")->required();
    sub->add_option("-o,--output", options->mesh, "mesh file to write: .ply, .obj or .glb")
        ->required()
        ->check(mesh_file_name());
    options->budget.add_to(*sub);
    sub->add_flag("--draco", options->draco, "compress the geometry of a .glb (KHR_draco_mesh_compression)");
    sub->callback([options, &command] {
        if (options->draco && mesh_format(options->mesh) != MeshFormat::glb)
            throw CLI::ValidationError("--draco", "only a .glb can be compressed");
        command = [options] { return decode(*options); };
    });
}

}  // namespace anyrate
