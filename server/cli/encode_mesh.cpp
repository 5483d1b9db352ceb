#include "core/encoding/encode_mesh.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "core/error.h"
#include "core/mesh/mesh_io.h"
#include "server/cli/commands.h"
#include "server/cli/interrupt.h"
#include "server/cli/log_id.h"
#include "server/cli/number_check.h"
#include "server/cli/progress_bar.h"
#include "server/cli/temporary_log.h"
#include "server/cli/thread_limit.h"
#include "server/jobs/durable_sink.h"

namespace anyrate {
namespace {

struct EncodeMeshCommand {
    std::filesystem::path mesh, model;
    EncodeMeshOptions options;
    std::optional<int> n_coarse;
    int n_threads = 0;
    bool quiet = false;
};

/// What the encoder tells, as the progress bar shows it: simplifying is a remeshing, splitting a refinement.
Progress shown(const EncodeProgress& progress, const EncodeMeshOptions& options) {
    if (progress.n_vertices == 0) return {.stage = Stage::remesh};
    const double to_go = std::max(1, options.n_vertices - options.n_coarse);
    return {.stage = Stage::refine,
            .fraction = (progress.n_vertices - options.n_coarse) / to_go,
            .n_vertices = progress.n_vertices};
}

void print_summary(const EncodeMeshCommand& request, const EncodeProgress& last, double seconds) {
    std::fprintf(stderr, "%s: %d vertices, %llu bytes, %.3g off (root mean square), %.1f s\n", request.model.c_str(),
                 last.n_vertices, static_cast<unsigned long long>(std::filesystem::file_size(request.model)),
                 last.rms_distance, seconds);
}

int encode_file(const EncodeMeshCommand& request) {
    const Interrupt interrupt;
    const ThreadLimit threads(request.n_threads);
    const auto begin = std::chrono::steady_clock::now();
    if (!std::filesystem::is_regular_file(request.mesh))
        throw InputError(request.mesh.string() + ": expected a mesh (.ply or .obj), found no such file");
    const Mesh mesh = read_mesh(request.mesh);
    const TemporaryLog temporary(request.model);
    EncodeProgress last;
    DurableSink log(log_id_of(mesh, request.options), temporary.path(), [](const RatePoint&) {});
    const EncodeEnd end = [&] {
        ProgressBar bar;
        const auto on_progress = [&](const EncodeProgress& progress) {
            last = progress;
            if (!request.quiet) bar.show(shown(progress, request.options));
        };
        return encode_mesh(mesh, request.options, log, on_progress, interrupt.token());
    }();
    if (end == EncodeEnd::before_the_base) {
        std::fprintf(stderr, "anyrate: interrupted before the coarse mesh was there; no model was written\n");
        return 1;
    }
    log.seal(request.model);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    if (!request.quiet) print_summary(request, last, elapsed.count());
    if (end == EncodeEnd::done) return 0;
    std::fprintf(stderr, "anyrate: interrupted; %s is a valid model that ends at its last whole frame, %d vertices\n",
                 request.model.c_str(), last.n_vertices);
    return 1;
}

}  // namespace

void add_encode_mesh(CLI::App& app, Command& command) {
    auto request = std::make_shared<EncodeMeshCommand>();
    CLI::App* sub = app.add_subcommand("encode-mesh", "write a closed surface, such as a scan, as a progressive model");
    sub->add_option("MESH", request->mesh, "a closed mesh of one piece (.ply or .obj); colours of its vertices stay")
        ->required();
    sub->add_option("-o,--output", request->model, "the model to write (.arl)")->required();
    sub->add_option("--vertices", request->options.n_vertices, "of the finest mesh")
        ->check(above_zero())
        ->capture_default_str();
    const int default_coarse = request->options.n_coarse;
    sub->add_option(
           "--coarse", request->n_coarse,
           "vertices of the coarse mesh (" + std::to_string(default_coarse) + ", or --vertices if that is less)")
        ->check(above_zero());
    sub->add_option("--threads", request->n_threads, "at most N threads; every processor by default")
        ->check(above_zero());
    sub->add_flag("--quiet", request->quiet, "say nothing but errors");
    sub->callback([request, default_coarse, &command] {
        request->options.n_coarse = request->n_coarse.value_or(std::min(default_coarse, request->options.n_vertices));
        request->options.name = request->mesh.string();
        command = [request] { return encode_file(*request); };
    });
}

}  // namespace anyrate
