#include "server/jobs/job_runner.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <new>
#include <optional>
#include <system_error>
#include <utility>

#include "core/capture/load_capture.h"
#include "core/error.h"
#include "server/jobs/durable_sink.h"
#include "server/jobs/job_journal.h"
#include "server/jobs/thumbnails.h"
#include "server/jobs/time_left.h"
#include "server/store/model_id.h"

namespace anyrate {
namespace {

constexpr const char* out_of_memory = "the reconstruction needs more memory than a worker may use";

using Report = std::function<void(const WorkerMessage&)>;

/// Reports each new stage at once and else at most five times a second: every report is a transaction of the catalog.
class ProgressReporter {
public:
    ProgressReporter(const Report& report, const ModelOptions& options)
        : report_(report), time_left_(options.n_vertices - options.n_coarse) {}

    /// The attempt begins, behind so much of the log.
    void begun(const LogMark& from, std::uint32_t n_vertices) {
        state_.n_bytes = from.n_bytes;
        state_.n_vertices = n_vertices;
        report_(JobBegun{from.n_bytes});
    }
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
        state_.seconds_left = 0;
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
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begun_;
        time_left_.reach(now.stage, now.fraction, elapsed.count());
        now.seconds_left = time_left_.seconds();
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
    TimeLeft time_left_;
    JobProgress state_;
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point sent_{};
};

class Attempt {
public:
    Attempt(const Job& job, const JobSteps& steps, LogStore& store, const Report& report, std::stop_token stop)
        : job_(job), steps_(steps), store_(store), progress_(report, job.options), stop_(std::move(stop)) {}

    /// @return whether the model was sealed; false if it was told to stop
    bool run() {
        auto log = store_.take(job_.model_id, job_.epoch);
        if (const auto view = store_.open_log(job_.model_id); view && view->sealed) {
            progress_.found(*view);
            drop_progress(*log);
            return true;
        }
        progress_.stage("load");
        Capture capture = steps_.load(job_.capture);
        if (stop_.stop_requested()) return false;
        if (!job_.thumbnails.empty()) write_thumbnails(capture, job_.thumbnails, job_.epoch);
        try {
            return go_on(std::move(capture), std::move(log));
        } catch (const LogDiverged&) {
            // Another machine, or another version of this program, began it. Clients are told by the log's new id.
            return begin(steps_.load(job_.capture), store_.take(job_.model_id, job_.epoch),
                         log_id_of(job_.model_id, job_.epoch));
        }
    }

private:
    bool go_on(Capture capture, std::unique_ptr<LogAppender> log) {
        const auto kept = kept_progress(*log);
        if (!kept) return begin(std::move(capture), std::move(log), log_id_of(job_.model_id, 1));
        const std::uint64_t log_id = kept->checkpoint.log_id;
        if (!kept->mark) {
            DurableSink sink(std::move(log), log_id, on_point(), {});
            progress_.begun({}, 0);
            return resume(std::move(capture), kept->checkpoint.start, std::nullopt, sink, log_id);
        }
        try {
            DurableSink sink(std::move(log), log_id, *kept->mark, on_point());
            RefinementPoint point{sink.state(), kept->mark->is_rejected};
            progress_.begun(*kept->mark, static_cast<std::uint32_t>(point.state.n_vertices()));
            return resume(std::move(capture), kept->checkpoint.start, std::move(point), sink, log_id);
        } catch (const DecodeError& error) {
            throw LogDiverged(error.what());  // the disk lost or changed what was durable
        }
    }

    bool begin(Capture capture, std::unique_ptr<LogAppender> log, std::uint64_t log_id) {
        drop_progress(*log);
        DurableSink sink(std::move(log), log_id, on_point(),
                         [this](const RatePoint& point) { progress_.preview(point); });
        progress_.begun({}, 0);
        JobJournal journal(sink, log_id);
        return end(sink, steps_.reconstruct(std::move(capture), options(), sink, on_progress(), stop_, journal));
    }

    bool resume(Capture capture, const RefinementStart& start, std::optional<RefinementPoint> point, DurableSink& sink,
                std::uint64_t log_id) {
        JobJournal journal(sink, log_id);
        return end(sink, steps_.resume(std::move(capture), options(), start, std::move(point), sink, on_progress(),
                                       stop_, journal));
    }

    bool end(DurableSink& sink, const ReconstructResult& result) {
        if (result.stopped) return false;
        progress_.stage("seal");
        sink.seal();
        progress_.sealed(store_.open_log(job_.model_id).value().size);
        drop_progress(sink.log());
        return true;
    }

    ReconstructOptions options() const {
        return {.n_vertices = job_.options.n_vertices, .n_coarse = job_.options.n_coarse};
    }
    DurableSink::PointFn on_point() {
        return [this](const RatePoint& point) { progress_.point(point); };
    }
    ProgressFn on_progress() {
        return [this](const Progress& now) { progress_.reconstruction(now); };
    }

    const Job& job_;
    const JobSteps& steps_;
    LogStore& store_;
    ProgressReporter progress_;
    std::stop_token stop_;
};

}  // namespace

JobSteps real_job_steps() {
    return {.load = [](const std::filesystem::path& file) { return load_capture(file); },
            .reconstruct =
                [](Capture capture, const ReconstructOptions& options, ModelSink& sink, const ProgressFn& progress,
                   std::stop_token stop, RefinementJournal& journal) {
                    return reconstruct(std::move(capture), options, sink, progress, stop, &journal);
                },
            .resume = resume};
}

void run_job(const Job& job, const JobSteps& steps, LogStore& store, const Report& report, std::stop_token stop) {
    const auto end = [&]() -> WorkerMessage {
        try {
            if (Attempt(job, steps, store, report, stop).run()) return JobDone{};
            return JobStopped{};
        } catch (const LeaseLost&) {
            return JobStopped{};  // somebody else makes the model now
        } catch (const DiskFull& error) {
            return JobFailed{.error = error.what(), .cause = FailureCause::no_room};
        } catch (const IoError& error) {
            return JobFailed{.error = error.what(), .cause = FailureCause::machine};
        } catch (const std::bad_alloc&) {
            return JobFailed{.error = out_of_memory};
        } catch (const std::system_error& error) {  // a thread found no room for its stack
            const bool is_memory = error.code() == std::errc::resource_unavailable_try_again;
            return JobFailed{.error = is_memory ? out_of_memory : error.what()};
        } catch (const std::exception& error) {
            return JobFailed{.error = error.what()};
        }
    }();
    report(end);
}

}  // namespace anyrate
