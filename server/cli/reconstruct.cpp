#include "core/reconstruction/reconstruct.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "core/capture/load_capture.h"
#include "core/error.h"
#include "proto/log_reader.h"
#include "server/cli/backend_choice.h"
#include "server/cli/commands.h"
#include "server/cli/interrupt.h"
#include "server/cli/log_id.h"
#include "server/cli/number_check.h"
#include "server/cli/one_of.h"
#include "server/cli/progress_bar.h"
#include "server/cli/read_log.h"
#include "server/cli/report.h"
#include "server/cli/temporary_log.h"
#include "server/cli/thread_limit.h"
#include "server/cli/timed_sink.h"
#include "server/jobs/durable_sink.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

const std::map<std::string, Method> methods = {
    {"refine", Method::refine}, {"flow", Method::flow}, {"uniform", Method::uniform}};
const std::map<std::string, Sampling> samplings = {{"adaptive", Sampling::adaptive}, {"uniform", Sampling::uniform}};

struct ReconstructCommand {
    std::filesystem::path capture, model;
    std::optional<std::filesystem::path> report;
    LoadOptions load;
    ReconstructOptions reconstruct;
    std::optional<int> n_coarse;
    BackendKind backend = BackendKind::automatic;
    int n_threads = 0;
    bool quiet = false;
};

std::string method_name(Method method) {
    for (const auto& [name, value] : methods) {
        if (value == method) return name;
    }
    return {};
}

void warn(const std::string& sentence) { std::fprintf(stderr, "anyrate: %s\n", sentence.c_str()); }

/// @param curve  its bytes become those of the sealed log, whose packets may hold several points
Report make_report(const ReconstructCommand& request, const BackendChoice& backend, std::optional<ReportPoint> preview,
                   std::vector<ReportPoint> curve, int n_threads, const ReconstructResult& result) {
    const auto log = read_log(request.model);
    const LogLayout layout = read_layout(log);
    for (ReportPoint& point : curve) {
        const VertexBudget budget{static_cast<std::uint32_t>(point.n_vertices)};
        point.bytes = prefix_end(layout.index, budget, layout.frames_begin);
    }
    return {.capture = request.capture.string(),
            .method = method_name(request.reconstruct.method),
            .backend = backend.name(),
            .device = backend.device,
            .n_threads = n_threads,
            .preview = preview,
            .curve = std::move(curve),
            .iterations = result.iterations,
            .max_distortion = layout.index.back().max_distortion,
            .log_bytes = log.size(),
            .stopped = result.stopped};
}

void print_summary(const ReconstructCommand& request, const Report& report, const StageClock& clock) {
    const ReportPoint& last = report.curve.back();
    std::fprintf(stderr, "%s: %d vertices, %llu bytes, psi %.2f, %.1f s\n", request.model.c_str(), last.n_vertices,
                 static_cast<unsigned long long>(report.log_bytes), last.psi, clock.total_seconds());
}

std::string sentence_of_halvings(int n_halvings, const LoadOptions& options) {
    return "the photographs together have more than " + std::to_string(options.max_kept_pixels / 1'000'000) +
           " megapixels, so 1/" + std::to_string(1 << n_halvings) + " of their width and height is used";
}

int reconstruct_capture(const ReconstructCommand& request) {
    const Interrupt interrupt;
    const ThreadLimit threads(request.n_threads);
    const BackendChoice backend = choose_backend(request.backend, warn);
    if (!request.quiet) warn(backend.sentence);
    StageClock clock;
    Capture capture = load_capture(request.capture, request.load);
    if (!request.quiet && capture.n_halvings > 0) warn(sentence_of_halvings(capture.n_halvings, request.load));

    const TemporaryLog temporary(request.model);
    std::vector<ReportPoint> curve;
    std::optional<ReportPoint> preview;
    const auto report_point = [&](const RatePoint& point) {
        return ReportPoint{static_cast<int>(point.n_vertices), point.n_bytes, point.psi, clock.total_seconds()};
    };
    DurableSink log(
        log_id_of(capture, request.reconstruct, backend.device), temporary.path(),
        [&](const RatePoint& point) { curve.push_back(report_point(point)); },
        [&](const RatePoint& point) { preview = report_point(point); });
    TimedSink sink(log, clock);
    const ReconstructResult result = [&] {
        ReconstructOptions options = request.reconstruct;
        options.backend = backend.factory;
        ProgressBar bar;
        const auto on_progress = [&](const Progress& progress) {
            clock.switch_to(activity_of(progress.stage));
            if (!request.quiet) bar.show(progress);
        };
        return reconstruct(std::move(capture), options, sink, on_progress, interrupt.token());
    }();
    if (curve.empty()) {
        std::fprintf(stderr, "anyrate: interrupted before the coarse mesh was there; no model was written\n");
        return 1;
    }
    log.seal(request.model);

    const Report report = make_report(request, backend, preview, std::move(curve), threads.n_threads(), result);
    if (request.report) replace_file(*request.report, as_bytes(report_json(report, clock)));
    if (!request.quiet) print_summary(request, report, clock);
    if (!result.stopped) return 0;
    std::fprintf(stderr, "anyrate: interrupted; %s is a valid model that ends at its last whole frame, %d vertices\n",
                 request.model.c_str(), report.curve.back().n_vertices);
    return 1;
}

void add_options(CLI::App& sub, ReconstructCommand& request) {
    sub.add_option("CAPTURE", request.capture, "folder or zip of images, masks and cameras")->required();
    sub.add_option("-o,--output", request.model, "the model to write (.arl)")->required();
    sub.add_option("--vertices", request.reconstruct.n_vertices, "of the finest mesh")
        ->check(above_zero())
        ->capture_default_str();
    sub.add_option("--coarse", request.n_coarse, "vertices of the coarse mesh (2500, or --vertices if that is less)")
        ->check(above_zero());
    sub.add_option("--cameras", request.load.cameras_file, "name of the camera file inside the capture")
        ->capture_default_str();
    sub.add_option("--backend", request.backend, "who computes photo-consistency: auto, cpu or gpu")
        ->transform(one_of(numbers_of(backend_kinds())));
    sub.add_option("--method", request.reconstruct.method,
                   "refine: the method; flow: surface flow alone; uniform: split the largest faces")
        ->transform(one_of(numbers_of(methods)));
    sub.add_option(
           "--sampling", request.reconstruct.sampling,
           "of the coarse mesh's optimisation: adaptive, samples by projected area; uniform: the same number in "
           "every triangle")
        ->transform(one_of(numbers_of(samplings)));
    sub.add_option("--samples-per-px", request.reconstruct.samples_per_px, "of --method flow")
        ->check(above_zero())
        ->capture_default_str();
    sub.add_option("--threads", request.n_threads, "at most N threads; every processor by default")
        ->check(above_zero());
    sub.add_option("--seed", request.reconstruct.seed, "of the random choices")->capture_default_str();
    sub.add_option("--report", request.report, "write times, memory and the rate-distortion curve as JSON");
    sub.add_flag("--quiet", request.quiet, "say nothing but errors");
}

}  // namespace

void add_reconstruct(CLI::App& app, Command& command) {
    auto request = std::make_shared<ReconstructCommand>();
    CLI::App* sub = app.add_subcommand("reconstruct", "rebuild an object from photographs as a progressive model");
    add_options(*sub, *request);
    sub->callback([request, &command] {
        const ReconstructOptions defaults;
        request->reconstruct.n_coarse =
            request->n_coarse.value_or(std::min(defaults.n_coarse, request->reconstruct.n_vertices));
        command = [request] { return reconstruct_capture(*request); };
    });
}

}  // namespace anyrate
