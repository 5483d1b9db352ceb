#pragma once
#include <sys/types.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/jobs/model_events.h"
#include "server/jobs/worker_message.h"
#include "server/store/catalog.h"

namespace anyrate {

/// The system's time.
Timestamp wall_clock();

struct SchedulerOptions {
    int n_workers = 1;     ///< jobs at a time
    int max_attempts = 3;  ///< in a row that get a job no further because its worker dies
    /// Likewise, because the server dies: seldom a job's fault. So many attempts may also meet a disk that fails,
    /// before another counts as if the worker had died.
    int max_restarts = 20;
    std::chrono::milliseconds stop_patience = std::chrono::seconds(5);  ///< for a worker that was told to stop
    std::chrono::milliseconds job_limit = std::chrono::hours(6);        ///< after this a worker is killed
    std::chrono::milliseconds retry_delay = std::chrono::seconds(1);    ///< before a job that failed is tried again
    std::chrono::milliseconds room_delay = std::chrono::seconds(10);    ///< before one that found the disk full is
    std::chrono::milliseconds lease = std::chrono::seconds(30);         ///< renewed three times as often
    std::function<Timestamp()> clock = wall_clock;                      ///< tests put another in its place
    /// Told when a stage of a job has ended, and how many seconds it took; called from several threads.
    std::function<void(const std::string& stage, double seconds)> on_stage = {};
};

/// The command that starts a worker for a claimed model.
using WorkerCommand = std::function<std::vector<std::string>(const ModelRecord& model)>;
/// Takes one line of news for the operator.
using LogLine = std::function<void(const std::string&)>;

/// Runs queued models, each attempt under a lease and in a worker process of its own, and keeps the catalog true:
/// progress, the end, a retry if the worker died. A catalog that fails for a while costs no job: what could not be
/// written is written when the lease has run out and the job is taken up again. Threads of its own, one a worker; safe
/// to call from several threads.
class Scheduler {
public:
    /// Requeues what a dead server left running, then starts: nobody else may work on the catalog. `catalog` and
    /// `events` must outlive it.
    Scheduler(Catalog& catalog, ModelEvents& events, WorkerCommand command, SchedulerOptions options, LogLine log);
    /// stop()
    ~Scheduler();

    /// There may be a new model in the queue.
    void wake();
    /// Kills the worker of a model, if it has one, and waits for its end. The caller has removed or cancelled the model
    /// in the catalog.
    void abandon(const std::string& id);
    /// Takes no new model, tells the workers to stop, waits for them and puts their models back in the queue.
    void stop();

private:
    class Attempt;

    void run_slot();
    void run_attempt(const ModelRecord& model);
    void recover_expired();
    std::vector<Lease> running_leases() const;
    Timestamp now() const { return options_.clock(); }
    RetryRule after_death() const;
    RetryRule after_failure(FailureCause cause, int n_attempts) const;
    bool is_stopping() const;

    Catalog& catalog_;
    ModelEvents& events_;
    WorkerCommand command_;
    SchedulerOptions options_;
    LogLine log_;

    std::mutex recovery_mutex_;
    Timestamp last_recovery_{};  ///< under recovery_mutex_

    mutable std::mutex mutex_;
    std::condition_variable woken_;
    bool stopping_ = false;
    std::uint64_t n_wakes_ = 0;
    struct Running {
        pid_t worker;
        Lease lease;
    };
    std::map<std::string, Running> running_;  ///< of each running model
    std::vector<std::jthread> slots_;
};

}  // namespace anyrate
