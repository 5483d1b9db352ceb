#include "server/jobs/job_runner.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <new>

#include "core/capture/load_capture.h"
#include "core/error.h"
#include "server/jobs/durable_sink.h"
#include "server/store/log_view.h"
#include "server/store/model_id.h"

namespace anyrate {
namespace {

using Report = std::function<void(const WorkerMessage&)>;

/// Reports each new stage at once and else at most five times a second: every report is a transaction of the catalog.
class ProgressReporter {
public:
    explicit ProgressReporter(const Report& report) : report_(report) {}

    void stage(const std::string& name) { progress({.stage = name, .fraction = 0, .psi = state_.psi}); }
    void reconstruction(const Progress& now) {
        progress({.stage = stage_name(now.stage),
                  .fraction = now.fraction,
                  .psi = now.psi > 0 ? std::optional(now.psi) : state_.psi});
    }
    /// A worker that died between sealing and saying so left the model finished.
    void found(const LogView& sealed_log) {
        const IndexRow& last = sealed_log.rows.back();
        state_ = {.stage = "seal", .fraction = 1, .n_vertices = last.n_vertices, .n_bytes = sealed_log.size};
        state_.psi = last.mean_distortion;
        send();
    }
    void sealed(std::uint64_t n_bytes) {
        state_.fraction = 1;
        state_.n_bytes = n_bytes;
        send();
    }
    void point(const RatePoint& point) {
        state_.psi = point.psi;
        report_(point);
        grown(point);
    }
    void preview(const RatePoint& point) { grown(point); }

private:
    void progress(JobProgress now) {
        const bool new_stage = now.stage != state_.stage;
        now.n_vertices = state_.n_vertices;
        now.n_bytes = state_.n_bytes;
        state_ = now;
        if (new_stage || std::chrono::steady_clock::now() - sent_ > std::chrono::milliseconds(200)) send();
    }
    void grown(const RatePoint& point) {
        state_.n_vertices = point.n_vertices;
        state_.n_bytes = point.n_bytes;
        send();
    }
    void send() {
        sent_ = std::chrono::steady_clock::now();
        report_(state_);
    }

    const Report& report_;
    JobProgress state_;
    std::chrono::steady_clock::time_point sent_{};
};

/// @return whether the model was sealed; false if it was told to stop
bool make_model(const Job& job, const JobSteps& steps, const Report& report, std::stop_token stop) {
    ProgressReporter progress(report);
    if (const auto log = open_log(job.paths.sealed_log, job.paths.live_log); log && log->sealed) {
        progress.found(*log);
        return true;
    }
    progress.stage("load");
    Capture capture = steps.load(job.paths.capture);
    if (stop.stop_requested()) return false;
    DurableSink sink(
        log_id_of_attempt(job.model_id, job.attempt), job.paths.live_log,
        [&](const RatePoint& point) { progress.point(point); },
        [&](const RatePoint& point) { progress.preview(point); });
    const ReconstructOptions options{.n_vertices = job.options.n_vertices, .n_coarse = job.options.n_coarse};
    const ReconstructResult result = steps.reconstruct(
        std::move(capture), options, sink, [&](const Progress& now) { progress.reconstruction(now); }, stop);
    if (result.stopped) return false;
    progress.stage("seal");
    sink.seal(job.paths.sealed_log);
    progress.sealed(std::filesystem::file_size(job.paths.sealed_log));
    return true;
}

}  // namespace

JobSteps real_job_steps() {
    return {.load = [](const std::filesystem::path& file) { return load_capture(file); },
            .reconstruct =
                [](Capture capture, const ReconstructOptions& options, ModelSink& sink, const ProgressFn& progress,
                   std::stop_token stop) { return reconstruct(std::move(capture), options, sink, progress, stop); }};
}

void run_job(const Job& job, const JobSteps& steps, const Report& report, std::stop_token stop) {
    const auto end = [&]() -> WorkerMessage {
        try {
            if (make_model(job, steps, report, stop)) return JobDone{};
            return JobStopped{};
        } catch (const IoError& error) {
            return JobFailed{.error = error.what(), .retry = true};
        } catch (const std::bad_alloc&) {
            return JobFailed{.error = "the reconstruction needs more memory than a worker may use"};
        } catch (const std::exception& error) {
            return JobFailed{.error = error.what()};
        }
    }();
    report(end);
}

}  // namespace anyrate
