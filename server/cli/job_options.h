#pragma once
#include <cstdint>
#include <optional>

#include "server/jobs/housekeeping.h"
#include "server/jobs/scheduler.h"

namespace CLI {
class App;
}

namespace anyrate {

/// What `serve` lets an operator say about jobs and about how long their models are kept.
struct JobOptions {
    int n_workers = 1;
    std::uint64_t worker_memory_mb = 4096;
    double job_minutes = 360;
    int max_attempts = 3;
    std::optional<double> keep_days;
    std::optional<std::uint64_t> keep_mb;

    SchedulerOptions scheduler() const;
};
void add_job_options(CLI::App& app, JobOptions& options);

/// `gc` has them too.
void add_keep_options(CLI::App& app, std::optional<double>& keep_days, std::optional<std::uint64_t>& keep_mb);
KeepRule keep_rule(const std::optional<double>& keep_days, const std::optional<std::uint64_t>& keep_mb);

}  // namespace anyrate
