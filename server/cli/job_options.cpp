#include "server/cli/job_options.h"

#include <CLI/CLI.hpp>
#include <chrono>

namespace anyrate {

SchedulerOptions JobOptions::scheduler() const {
    SchedulerOptions options;
    options.n_workers = n_workers;
    options.max_attempts = max_attempts;
    using Minutes = std::chrono::duration<double, std::ratio<60>>;
    options.job_limit = std::chrono::duration_cast<std::chrono::milliseconds>(Minutes(job_minutes));
    return options;
}

void add_job_options(CLI::App& app, JobOptions& options) {
    app.add_option("--workers", options.n_workers, "reconstructions at a time")
        ->envname("ANYRATE_WORKERS")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    app.add_option("--worker-memory", options.worker_memory_mb, "MB a worker may use; 0 for no limit")
        ->envname("ANYRATE_WORKER_MEMORY")
        ->capture_default_str();
    app.add_option("--job-minutes", options.job_minutes, "after which an attempt at a model is given up, and the model")
        ->envname("ANYRATE_JOB_MINUTES")
        ->check(CLI::Range(0.001, 1e6))
        ->capture_default_str();
    app.add_option("--max-attempts", options.max_attempts,
                   "in a row that get a model no further because its worker dies; then it fails")
        ->envname("ANYRATE_MAX_ATTEMPTS")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    add_keep_options(app, options.keep_days, options.keep_mb);
    // Of a server only: `gc` in the same environment removes what it is told to in its own command line.
    app.get_option("--keep-days")->envname("ANYRATE_KEEP_DAYS");
    app.get_option("--keep-mb")->envname("ANYRATE_KEEP_MB");
}

void add_keep_options(CLI::App& app, std::optional<double>& keep_days, std::optional<std::uint64_t>& keep_mb) {
    app.add_option("--keep-days", keep_days, "remove models that became final longer ago; without it none")
        ->check(CLI::Range(0.0, 1e6));
    app.add_option("--keep-mb", keep_mb, "remove the oldest final models beyond so many MB of all models; likewise")
        ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 40));
}

KeepRule keep_rule(const std::optional<double>& keep_days, const std::optional<std::uint64_t>& keep_mb) {
    KeepRule rule;
    using Days = std::chrono::duration<double, std::ratio<86400>>;
    if (keep_days) rule.age = std::chrono::duration_cast<std::chrono::milliseconds>(Days(*keep_days));
    if (keep_mb) rule.bytes = *keep_mb << 20;
    return rule;
}

}  // namespace anyrate
