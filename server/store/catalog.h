#pragma once
#include <chrono>
#include <cstdint>
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
    double fraction = 0;             ///< of the stage, 0..1
    std::uint32_t n_vertices = 0;    ///< that are in the durable log
    std::uint64_t n_bytes = 0;       ///< of the durable log
    std::optional<double> psi = {};  ///< Eq. 10, squared 8-bit colour units
    friend bool operator==(const JobProgress&, const JobProgress&) = default;
};

/// One point of the rate-distortion curve.
struct RatePoint {
    std::uint32_t n_vertices = 0;
    std::uint64_t n_bytes = 0;  ///< of the live log up to there
    double psi = 0;
    double seconds = 0;  ///< since the attempt began
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
    /// @param after  id of the last model of the page before; empty for the first page; an unknown id gives an empty
    /// page
    virtual ModelPage list(std::size_t limit, const std::string& after) = 0;
    virtual std::vector<RatePoint> curve(const std::string& id) = 0;
    /// Forgets a model in any state. @return whether it was there
    virtual bool remove(const std::string& id) = 0;

    /// Takes the oldest queued model for one attempt: it is running, has one attempt more, and neither progress nor
    /// curve.
    virtual std::optional<ModelRecord> claim_next(Timestamp now) = 0;
    /// The three calls of a running attempt change nothing if the model is not running (it was cancelled or removed).
    virtual void report(const std::string& id, const JobProgress& progress, Timestamp now) = 0;
    virtual void add_rate_point(const std::string& id, const RatePoint& point) = 0;
    /// @param error  the sentence if the state is failed
    virtual void finish(const std::string& id, ModelState state, const std::string& error, Timestamp now) = 0;

    /// Puts a running model back in the queue; with `max_attempts` behind it, it fails with `error` instead.
    virtual void retry(const std::string& id, int max_attempts, const std::string& error, Timestamp now) = 0;
    /// Puts a running model back in the queue as if the attempt had not been made (the server stops).
    virtual void give_back(const std::string& id, Timestamp now) = 0;
    /// Running models that a dead server left behind: retry() for each. @return how many
    virtual int recover(int max_attempts, const std::string& error, Timestamp now) = 0;
};

}  // namespace anyrate
