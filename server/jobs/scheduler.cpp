#include "server/jobs/scheduler.h"

#include <signal.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "server/jobs/worker_message.h"
#include "server/jobs/worker_process.h"

namespace anyrate {
namespace {

using std::chrono::steady_clock;

Timestamp now() { return std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now()); }

constexpr const char* recovered_error = "the server stopped in the middle of every attempt at this model";

}  // namespace

/// One attempt: passes a worker's messages to the catalog until its output ends, and settles how it ended.
class Scheduler::Attempt {
public:
    Attempt(Scheduler& scheduler, const ModelRecord& model) : scheduler_(scheduler), model_(model) {}
    ~Attempt() {
        {
            const std::lock_guard lock(scheduler_.mutex_);
            scheduler_.running_.erase(model_.id);
        }
        scheduler_.woken_.notify_all();
    }

    void run() {
        if (!start()) return;
        read_messages();
        const std::string how = worker_->wait(std::chrono::seconds(2));
        settle(how);
        scheduler_.events_.notify(model_.id);
    }

private:
    /// @return whether there is a worker: a model withdrawn since its claim gets none. Under the lock of abandon(),
    /// which comes after the withdrawal: either this sees the withdrawal or abandon() sees the worker.
    bool start() {
        const std::vector<std::string> command = scheduler_.command_(model_);
        const std::lock_guard lock(scheduler_.mutex_);
        const auto record = scheduler_.catalog_.find(model_.id);
        if (!record || record->state != ModelState::running) return false;
        worker_.emplace(command);
        scheduler_.running_[model_.id] = worker_->pid();
        return true;
    }

    void read_messages() {
        std::string line;
        for (;;) {
            const auto read = worker_->read_line(line, std::chrono::milliseconds(100));
            if (read == WorkerProcess::Read::end) return;
            if (read == WorkerProcess::Read::line) take(line);
            enforce_limits();
        }
    }

    void take(const std::string& line) {
        try {
            std::visit([this](const auto& message) { apply(message); }, decode_worker_message(line));
            scheduler_.events_.notify(model_.id);
        } catch (const DecodeError& error) {
            scheduler_.log_("model " + model_.id + ": " + error.what());
        }
    }
    void apply(const JobProgress& progress) { scheduler_.catalog_.report(model_.id, progress, now()); }
    void apply(const RatePoint& point) { scheduler_.catalog_.add_rate_point(model_.id, point); }
    void apply(const JobFailed& failed) { failed_ = failed; }
    void apply(const JobDone&) { done_ = true; }
    void apply(const JobStopped&) {}

    void enforce_limits() {
        const auto time = steady_clock::now();
        if (scheduler_.is_stopping() && !kill_at_) {
            worker_->signal(SIGTERM);
            kill_at_ = time + scheduler_.options_.stop_patience;
        }
        if (kill_at_ && time > *kill_at_) worker_->signal(SIGKILL);
        if (!failed_ && time - begun_ > scheduler_.options_.job_limit) {
            failed_ = JobFailed{.error = "the reconstruction took longer than the server allows"};
            worker_->signal(SIGKILL);
        }
    }

    void settle(const std::string& how) {
        Catalog& catalog = scheduler_.catalog_;
        if (done_) {
            catalog.finish(model_.id, ModelState::done, "", now());
            scheduler_.log_("model " + model_.id + ": done");
        } else if (failed_ && !failed_->retry) {
            catalog.finish(model_.id, ModelState::failed, failed_->error, now());
            scheduler_.log_("model " + model_.id + ": failed: " + failed_->error);
        } else if (scheduler_.is_stopping()) {
            catalog.give_back(model_.id, now());
        } else {
            const std::string error = failed_ ? failed_->error : "the worker process ended with " + how;
            catalog.retry(model_.id, scheduler_.options_.max_attempts, error, now());
            scheduler_.log_("model " + model_.id + ": attempt " + std::to_string(model_.attempts) + ": " + error);
        }
    }

    Scheduler& scheduler_;
    const ModelRecord& model_;
    std::optional<WorkerProcess> worker_;
    steady_clock::time_point begun_ = steady_clock::now();
    std::optional<steady_clock::time_point> kill_at_;
    std::optional<JobFailed> failed_;
    bool done_ = false;
};

Scheduler::Scheduler(Catalog& catalog, ModelEvents& events, WorkerCommand command, SchedulerOptions options,
                     LogLine log)
    : catalog_(catalog), events_(events), command_(std::move(command)), options_(options), log_(std::move(log)) {
    const int n_recovered = catalog_.recover(options_.max_attempts, recovered_error, now());
    if (n_recovered > 0) log_(std::to_string(n_recovered) + " interrupted models found");
    for (int i = 0; i < options_.n_workers; ++i) slots_.emplace_back([this] { run_slot(); });
}

Scheduler::~Scheduler() { stop(); }

void Scheduler::wake() {
    {
        const std::lock_guard lock(mutex_);
        ++n_wakes_;
    }
    woken_.notify_all();
}

void Scheduler::abandon(const std::string& id) {
    std::unique_lock lock(mutex_);
    const auto worker = running_.find(id);
    if (worker == running_.end()) return;
    ::kill(worker->second, SIGKILL);
    woken_.wait_for(lock, std::chrono::seconds(5), [&] { return !running_.contains(id); });
}

void Scheduler::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    woken_.notify_all();
    slots_.clear();  // joins
}

bool Scheduler::is_stopping() const {
    const std::lock_guard lock(mutex_);
    return stopping_;
}

void Scheduler::run_slot() {
    for (;;) {
        std::uint64_t seen = 0;
        {
            const std::lock_guard lock(mutex_);
            if (stopping_) return;
            seen = n_wakes_;
        }
        try {
            if (const auto model = catalog_.claim_next(now())) {
                run_attempt(*model);
                continue;
            }
        } catch (const IoError& error) {
            log_(std::string("scheduler: ") + error.what());
        }
        // The second of patience is for a catalog that failed; a new model wakes at once.
        std::unique_lock lock(mutex_);
        woken_.wait_for(lock, std::chrono::seconds(1), [&] { return stopping_ || n_wakes_ != seen; });
    }
}

void Scheduler::run_attempt(const ModelRecord& model) {
    events_.notify(model.id);
    log_("model " + model.id + ": attempt " + std::to_string(model.attempts));
    try {
        Attempt(*this, model).run();
    } catch (const IoError& error) {
        catalog_.retry(model.id, options_.max_attempts, error.what(), now());
        events_.notify(model.id);
        throw;
    }
}

}  // namespace anyrate
