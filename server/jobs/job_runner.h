#pragma once
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "core/capture/capture.h"
#include "core/reconstruction/reconstruct.h"
#include "server/jobs/worker_message.h"
#include "server/store/model_store.h"

namespace anyrate {

/// One attempt at a model, as a worker process sees it.
struct Job {
    std::string model_id;
    ModelPaths paths;
    ModelOptions options;
    int attempt = 1;
};

/// The two steps that make a model; tests put quick ones in their place.
struct JobSteps {
    std::function<Capture(const std::filesystem::path& folder_or_zip)> load;
    std::function<ReconstructResult(Capture, const ReconstructOptions&, ModelSink&, const ProgressFn&, std::stop_token)>
        reconstruct;
};
/// load_capture() and reconstruct().
JobSteps real_job_steps();

/// Loads the capture, reconstructs it into the live log (every frame durable before it is reported) and seals the log.
/// Ends with exactly one JobDone, JobFailed or JobStopped to `report`; throws nothing but what `report` throws.
/// A stopped job leaves no sealed log: it is run again from the start. One whose log is sealed already is done at once.
void run_job(const Job& job, const JobSteps& steps, const std::function<void(const WorkerMessage&)>& report,
             std::stop_token stop);

}  // namespace anyrate
