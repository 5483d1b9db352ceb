#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "core/capture/capture.h"
#include "core/reconstruction/reconstruct.h"
#include "server/jobs/worker_message.h"
#include "server/store/catalog.h"
#include "server/store/log_store.h"

namespace anyrate {

/// One attempt at a model, as a worker process sees it.
struct Job {
    std::string model_id;
    std::filesystem::path capture;
    std::filesystem::path thumbnails{};  ///< where they are to be; empty: none are wanted
    ModelOptions options;
    std::uint64_t epoch = 1;  ///< of the lease
};

/// The steps that make a model; tests put quick ones in their place.
struct JobSteps {
    std::function<Capture(const std::filesystem::path& folder_or_zip)> load;
    std::function<ReconstructResult(Capture, const ReconstructOptions&, ModelSink&, const ProgressFn&, std::stop_token,
                                    RefinementJournal&)>
        reconstruct;
    std::function<ReconstructResult(Capture, const ReconstructOptions&, const RefinementStart&,
                                    std::optional<RefinementPoint>, ModelSink&, const ProgressFn&, std::stop_token,
                                    RefinementJournal&)>
        resume;
};
/// load_capture(), reconstruct() and resume().
JobSteps real_job_steps();

/// Loads the capture, reconstructs it into the live log (every frame durable before it is reported) and seals the log.
/// Where an earlier attempt left a log and what is needed to go on with it, the job goes on behind its last whole
/// batch, and the sealed log is the one that an undisturbed attempt makes. Ends with exactly one JobDone, JobFailed or
/// JobStopped to `report`; throws nothing but what `report` throws. One whose log is sealed already is done at once.
void run_job(const Job& job, const JobSteps& steps, LogStore& store,
             const std::function<void(const WorkerMessage&)>& report, std::stop_token stop);

}  // namespace anyrate
