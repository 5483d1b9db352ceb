#include "server/jobs/scheduler.h"

#include <signal.h>

#include <algorithm>
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

constexpr const char* recovered_error = "the server stopped, or lost its worker, in every attempt at this model";

}  // namespace

Timestamp wall_clock() {
    return std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

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
        if (holds_lease_) settle(how);
        scheduler_.events_.notify(model_.id);
    }

private:
    /// @return whether there is a worker: a model withdrawn since its claim gets none. Under the lock of abandon(),
    /// which comes after the withdrawal: either this sees the withdrawal or abandon() sees the worker.
    bool start() {
        const std::vector<std::string> command = scheduler_.command_(model_);
        const std::lock_guard lock(scheduler_.mutex_);
        const auto record = scheduler_.catalog_.find(model_.id);
        if (!record || record->state != ModelState::running || record->epoch != lease_.epoch) return false;
        worker_.emplace(command);
        scheduler_.running_.insert_or_assign(model_.id, Running{worker_->pid(), lease_});
        return true;
    }

    void read_messages() {
        std::string line;
        for (;;) {
            const auto read = worker_->read_line(line, std::chrono::milliseconds(100));
            if (read == WorkerProcess::Read::end) return;
            if (read == WorkerProcess::Read::line) take(line);
            enforce_limits();
            renew_lease();
            if (!holds_lease_) worker_->signal(SIGKILL);
        }
    }

    void take(const std::string& line) {
        try {
            std::visit([this](const auto& message) { apply(message); }, decode_worker_message(line));
            scheduler_.events_.notify(model_.id);
        } catch (const DecodeError& error) {
            scheduler_.log_("model " + model_.id + ": " + error.what());
        } catch (const IoError& error) {
            // The log has what the catalog misses; the job itself goes on.
            if (!std::exchange(has_complained_, true)) scheduler_.log_("model " + model_.id + ": " + error.what());
        }
    }
    void apply(const JobBegun& begun) { keep(scheduler_.catalog_.begin(lease_, begun.n_bytes, scheduler_.now())); }
    void apply(const JobProgress& progress) {
        if (progress.stage != stage_) end_stage(progress.stage);
        keep(scheduler_.catalog_.report(lease_, progress, scheduler_.now()));
    }
    void apply(const RatePoint& point) { keep(scheduler_.catalog_.add_rate_point(lease_, point)); }
    void apply(const JobFailed& failed) { failed_ = failed; }
    void apply(const JobDone&) { done_ = true; }
    void apply(const JobStopped&) {}

    void end_stage(const std::string& next) {
        const std::chrono::duration<double> taken = steady_clock::now() - stage_begun_;
        if (!stage_.empty() && scheduler_.options_.on_stage) scheduler_.options_.on_stage(stage_, taken.count());
        stage_ = next;
        stage_begun_ = steady_clock::now();
    }

    void keep(bool holds_lease) { holds_lease_ = holds_lease_ && holds_lease; }

    void renew_lease() {
        const auto time = steady_clock::now();
        if (time - renewed_ < scheduler_.options_.lease / 3) return;
        try {
            keep(scheduler_.catalog_.renew(lease_, scheduler_.now() + scheduler_.options_.lease));
            renewed_ = time;
        } catch (const IoError&) {  // it is tried again, as long as the lease lasts
            if (time - renewed_ > scheduler_.options_.lease) keep(false);
        }
    }

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
            end_stage("");
            catalog.finish(lease_, ModelState::done, "", scheduler_.now());
            scheduler_.log_("model " + model_.id + ": done");
        } else if (failed_ && failed_->cause == FailureCause::capture) {
            catalog.finish(lease_, ModelState::failed, failed_->error, scheduler_.now());
            scheduler_.log_("model " + model_.id + ": failed: " + failed_->error);
        } else if (scheduler_.is_stopping()) {
            catalog.give_back(lease_, scheduler_.now());
        } else {
            const std::string error = failed_ ? failed_->error : "the worker process ended with " + how;
            const RetryRule rule =
                failed_ ? scheduler_.after_failure(failed_->cause, model_.attempts) : scheduler_.after_death();
            catalog.retry(lease_, rule, error, scheduler_.now());
            scheduler_.log_("model " + model_.id + ": attempt " + std::to_string(model_.attempts) + ": " + error);
        }
    }

    Scheduler& scheduler_;
    const ModelRecord& model_;
    const Lease lease_ = lease_of(model_);
    std::optional<WorkerProcess> worker_;
    std::string stage_;
    steady_clock::time_point stage_begun_ = steady_clock::now();
    bool holds_lease_ = true, has_complained_ = false;
    steady_clock::time_point renewed_ = steady_clock::now();
    steady_clock::time_point begun_ = steady_clock::now();
    std::optional<steady_clock::time_point> kill_at_;
    std::optional<JobFailed> failed_;
    bool done_ = false;
};

Scheduler::Scheduler(Catalog& catalog, ModelEvents& events, WorkerCommand command, SchedulerOptions options,
                     LogLine log)
    : catalog_(catalog), events_(events), command_(std::move(command)), options_(options), log_(std::move(log)) {
    const RetryRule at_once{.max_fruitless = options_.max_restarts, .not_before = now()};
    const int n_recovered = catalog_.recover(Timestamp::max(), at_once, recovered_error, now());
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
    ::kill(worker->second.worker, SIGKILL);
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

std::vector<Lease> Scheduler::running_leases() const {
    const std::lock_guard lock(mutex_);
    std::vector<Lease> leases;
    for (const auto& [id, running] : running_) leases.push_back(running.lease);
    return leases;
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
            recover_expired();
            if (const auto model = catalog_.claim_next(now(), now() + options_.lease)) {
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
        // The worker could not be started, or its end not be written down; in the second case this fails as well, and
        // the lease will run out.
        const RetryRule rule = after_failure(FailureCause::machine, model.attempts);
        catalog_.retry(lease_of(model), rule, error.what(), now());
        events_.notify(model.id);
        throw;
    }
}

void Scheduler::recover_expired() {
    const std::lock_guard lock(recovery_mutex_);
    const Timestamp time = now();
    // Nobody looked for long: the clock was set forward, or the machine slept. Who runs here holds its lease all the
    // same.
    if (time - std::exchange(last_recovery_, time) > options_.lease / 3)
        for (const Lease& lease : running_leases()) catalog_.renew(lease, time + options_.lease);
    // Whose end could not be written down: the catalog's failure, not the job's.
    const RetryRule rule{.max_fruitless = options_.max_attempts, .is_counted = false, .not_before = time};
    const int n_recovered = catalog_.recover(time, rule, recovered_error, time);
    if (n_recovered > 0) log_(std::to_string(n_recovered) + " models taken up again whose leases had run out");
}

RetryRule Scheduler::after_death() const {
    return {.max_fruitless = options_.max_attempts, .not_before = now() + options_.retry_delay};
}

RetryRule Scheduler::after_failure(FailureCause cause, int n_attempts) const {
    RetryRule rule = after_death();
    if (cause == FailureCause::no_room) {
        rule.is_counted = false;
        rule.not_before = now() + options_.room_delay;
    } else {
        // A disk may fail for a while: ever longer waits, about three minutes in all.
        rule.is_counted = n_attempts > options_.max_restarts;
        rule.not_before = now() + std::min(options_.room_delay, n_attempts * options_.retry_delay);
    }
    return rule;
}

}  // namespace anyrate
