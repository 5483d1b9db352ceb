#pragma once
#include <chrono>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace anyrate {

using Timestamp = std::chrono::sys_time<std::chrono::milliseconds>;

enum class ModelState { queued, running, done, failed, cancelled };
const char* state_name(ModelState state);
bool is_final(ModelState state);  ///< done, failed and cancelled: it will not change any more

/// What somebody asked of a model.
struct ModelOptions {
    int n_vertices = 10'000;
    int n_coarse = 2'500;
    friend bool operator==(const ModelOptions&, const ModelOptions&) = default;
};

/// How far a job is; what a worker reports.
struct JobProgress {
    std::string stage;
    double fraction = 0;                      ///< of the stage, 0..1
    std::uint32_t n_vertices = 0;             ///< that are in the durable log
    std::uint64_t n_bytes = 0;                ///< of the durable log
    std::optional<double> psi = {};           ///< Eq. 10, squared 8-bit colour units
    std::optional<double> seconds_left = {};  ///< of the whole job, an estimate
    friend bool operator==(const JobProgress&, const JobProgress&) = default;
};

/// One point of the rate-distortion curve.
struct RatePoint {
    std::uint32_t n_vertices = 0;
    std::uint64_t n_bytes = 0;  ///< of the live log up to there
    double psi = 0;
    double seconds = 0;  ///< that workers have spent on it up to there, whatever was lost with one not counted
    friend bool operator==(const RatePoint&, const RatePoint&) = default;
};

/// A row of the catalog.
struct ModelRecord {
    std::string id;
    ModelState state = ModelState::queued;
    ModelOptions options;
    JobProgress progress;
    std::string error;  ///< the sentence of a failed model
    int attempts = 0;   ///< begun so far
    Timestamp created{}, updated{};
    std::uint64_t epoch = 0;   ///< of the latest lease; 0 before the first
    std::uint64_t number = 0;  ///< in order of arrival; none has that of another, also of one that was removed
};

/// The right to run one attempt at a model. It ends when it is not renewed in time, and when the model is cancelled or
/// removed; from then on its holder changes nothing in the catalog, nor in the log (LogStore::take).
struct Lease {
    std::string id;
    std::uint64_t epoch = 0;  ///< grows from lease to lease of a model
};
inline Lease lease_of(const ModelRecord& claimed) { return {claimed.id, claimed.epoch}; }

/// How a model that failed without its own fault is tried again.
struct RetryRule {
    int max_fruitless = 3;   ///< attempts in a row that took the curve no further than it has been; then it fails
    bool is_counted = true;  ///< whether this attempt may be one of them
    Timestamp not_before{};  ///< of the next attempt; more than ten minutes ahead counts for nothing
};

struct NewModel {
    std::string id;
    ModelOptions options;
    std::string idempotency_key;      ///< empty for none
    std::string request_fingerprint;  ///< tells two requests with one key apart
};

/// What add() did. A key that is known gives the model that was made under it.
struct Added {
    enum class Kind { made, repeated, key_reused } kind = Kind::made;
    std::string id;  ///< of the new model, or of the earlier one
};

/// A page of list(): newest first.
struct ModelPage {
    std::vector<ModelRecord> models;
    bool more = false;  ///< there are older ones than the last
};

/// The durable list of models and, at the same time, the queue of jobs. Whatever a call acknowledges has survived a
/// crash of the process. Safe to call from several threads. Every call may throw IoError.
class Catalog {
public:
    virtual ~Catalog() = default;

    /// Enters a model as queued. `key_reused` if the idempotency key belongs to a request with another fingerprint.
    virtual Added add(const NewModel& model, Timestamp now) = 0;
    virtual std::optional<ModelRecord> find(const std::string& id) = 0;
    static constexpr std::uint64_t from_newest = std::numeric_limits<std::int64_t>::max();  ///< of list()
    /// @param before  number of the last model of the page before, which may be gone by now; or from_newest
    virtual ModelPage list(std::size_t limit, std::uint64_t before) = 0;
    virtual std::vector<RatePoint> curve(const std::string& id) = 0;
    /// Forgets a model in any state. @return whether it was there
    virtual bool remove(const std::string& id) = 0;

    /// Withdraws a model that is queued or running. @return whether it was
    virtual bool cancel(const std::string& id, Timestamp now) = 0;
    /// How many models are in each state that any is in.
    virtual std::map<ModelState, std::size_t> counts() = 0;
    /// Final models that have not changed since `before`, the oldest first.
    virtual std::vector<ModelRecord> final_before(Timestamp before) = 0;

    /// Takes a queued model whose time has come for one attempt, under a new lease: it is running and has one attempt
    /// more. Its curve stays, for the attempt may go on with the log. The oldest goes first, but behind all that had
    /// fewer fruitless attempts (RetryRule): one that takes its server or its workers down lets the others by, and a
    /// server that is killed again and again does not spend every attempt on the same model.
    virtual std::optional<ModelRecord> claim_next(Timestamp now, Timestamp lease_until = Timestamp::max()) = 0;

    // The calls of a running attempt. @return false, and nothing changes, if the lease is over
    virtual bool renew(const Lease& lease, Timestamp lease_until) = 0;
    /// The attempt goes on behind the first `n_bytes` of the log, 0 for anew: later points of the curve are forgotten.
    virtual bool begin(const Lease& lease, std::uint64_t n_bytes, Timestamp now) = 0;
    virtual bool report(const Lease& lease, const JobProgress& progress, Timestamp now) = 0;
    virtual bool add_rate_point(const Lease& lease, const RatePoint& point) = 0;
    /// @param error  the sentence if the state is failed
    virtual bool finish(const Lease& lease, ModelState state, const std::string& error, Timestamp now) = 0;
    /// Puts the model back in the queue; when the rule allows no more, it fails with `error` instead.
    virtual bool retry(const Lease& lease, const RetryRule& rule, const std::string& error, Timestamp now) = 0;
    /// Puts the model back in the queue as if the attempt had not been made (the server stops).
    virtual bool give_back(const Lease& lease, Timestamp now) = 0;

    /// Running models whose lease ends at `end` or before, because whoever held it is gone: retry() for each. @return
    /// how many
    virtual int recover(Timestamp end, const RetryRule& rule, const std::string& error, Timestamp now) = 0;
};

}  // namespace anyrate
