#include "server/store/sqlite_catalog.h"

#include <mutex>
#include <nlohmann/json.hpp>

#include "server/store/catalog_format.h"
#include "server/store/sqlite.h"

namespace anyrate {
namespace {

constexpr const char* record_columns =
    "id, state, options, stage, fraction, vertices, bytes, psi, error, attempts, created, updated, epoch, "
    "seconds_left, "
    "number";

/// What ends an attempt that is to be tried again; ?1 the limit, ?2 what it counts, ?3 the sentence, ?4 not before, ?5
/// now.
constexpr const char* set_retried =
    "UPDATE model SET fruitless = fruitless + ?2, state = iif(fruitless + ?2 < ?1, 'queued', 'failed'), "
    "error = iif(fruitless + ?2 < ?1, '', ?3), not_before = ?4, updated = ?5, seconds_left = NULL ";

std::int64_t to_number(Timestamp time) { return time.time_since_epoch().count(); }

ModelState state_of(const std::string& name) {
    for (const auto state : {ModelState::queued, ModelState::running, ModelState::done, ModelState::failed})
        if (name == state_name(state)) return state;
    return ModelState::cancelled;
}

std::string options_to_json(const ModelOptions& options) {
    return nlohmann::json{{"vertices", options.n_vertices}, {"coarse", options.n_coarse}}.dump();
}

ModelOptions options_from_json(const std::string& text) {
    const auto json = nlohmann::json::parse(text);
    return {.n_vertices = json.at("vertices"), .n_coarse = json.at("coarse")};
}

ModelRecord read_record(SqliteStatement& row) {
    ModelRecord record;
    record.id = row.text(0);
    record.state = state_of(row.text(1));
    record.options = options_from_json(row.text(2));
    record.progress = {.stage = row.text(3),
                       .fraction = row.real(4),
                       .n_vertices = static_cast<std::uint32_t>(row.integer(5)),
                       .n_bytes = static_cast<std::uint64_t>(row.integer(6)),
                       .psi = row.is_null(7) ? std::nullopt : std::optional(row.real(7)),
                       .seconds_left = row.is_null(13) ? std::nullopt : std::optional(row.real(13))};
    record.error = row.text(8);
    record.attempts = static_cast<int>(row.integer(9));
    record.created = Timestamp(std::chrono::milliseconds(row.integer(10)));
    record.updated = Timestamp(std::chrono::milliseconds(row.integer(11)));
    record.epoch = static_cast<std::uint64_t>(row.integer(12));
    record.number = static_cast<std::uint64_t>(row.integer(14));
    return record;
}

}  // namespace

struct SqliteCatalog::State {
    explicit State(const std::filesystem::path& file) : database(file) {}

    SqliteDatabase database;
    std::mutex mutex;

    /// Changes the model of a lease, if that holds: the last two values of the statement are id and epoch.
    template <class... Values>
    bool run_leased(const std::string& sql, const Lease& lease, const Values&... values) {
        database.run(sql + " WHERE id = ? AND epoch = ? AND state = 'running'", values..., lease.id, lease.epoch);
        return database.n_changes() > 0;
    }
    bool holds(const Lease& lease) {
        return SqliteStatement(database, "SELECT 1 FROM model WHERE id = ? AND epoch = ? AND state = 'running'",
                               lease.id, lease.epoch)
            .next();
    }
    std::optional<ModelRecord> find(const std::string& id) {
        SqliteStatement row(database, std::string("SELECT ") + record_columns + " FROM model WHERE id = ?", id);
        return row.next() ? std::optional(read_record(row)) : std::nullopt;
    }
};

SqliteCatalog::SqliteCatalog(const std::filesystem::path& file) : state_(std::make_unique<State>(file)) {
    // FULL: an acknowledged upload survives a power cut, not only a crash of the process.
    state_->database.run_script("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON");
    bring_up_to_date(state_->database, file);
}

SqliteCatalog::~SqliteCatalog() = default;

Added SqliteCatalog::add(const NewModel& model, Timestamp now) {
    const std::lock_guard lock(state_->mutex);
    return state_->database.transaction([&]() -> Added {
        if (!model.idempotency_key.empty()) {
            SqliteStatement row(state_->database, "SELECT id, fingerprint FROM model WHERE idempotency_key = ?",
                                model.idempotency_key);
            if (row.next())
                return {row.text(1) == model.request_fingerprint ? Added::Kind::repeated : Added::Kind::key_reused,
                        row.text(0)};
        }
        state_->database.run(
            "INSERT INTO model (id, state, options, created, updated, idempotency_key, fingerprint) "
            "VALUES (?, 'queued', ?, ?, ?, nullif(?, ''), ?)",
            model.id, options_to_json(model.options), to_number(now), to_number(now), model.idempotency_key,
            model.request_fingerprint);
        return {Added::Kind::made, model.id};
    });
}

std::optional<ModelRecord> SqliteCatalog::find(const std::string& id) {
    const std::lock_guard lock(state_->mutex);
    return state_->find(id);
}

ModelPage SqliteCatalog::list(std::size_t limit, std::uint64_t before) {
    const std::lock_guard lock(state_->mutex);
    state_->database.expect_in_place();
    SqliteStatement row(
        state_->database,
        std::string("SELECT ") + record_columns + " FROM model WHERE number < ? ORDER BY number DESC LIMIT ?", before,
        limit + 1);
    ModelPage page;
    while (row.next()) {
        if (page.models.size() == limit) {
            page.more = true;
            break;
        }
        page.models.push_back(read_record(row));
    }
    return page;
}

std::vector<RatePoint> SqliteCatalog::curve(const std::string& id) {
    const std::lock_guard lock(state_->mutex);
    SqliteStatement row(state_->database,
                        "SELECT vertices, bytes, psi, seconds FROM rate_point "
                        "WHERE model = (SELECT number FROM model WHERE id = ?) ORDER BY rowid",
                        id);
    std::vector<RatePoint> points;
    while (row.next())
        points.push_back({.n_vertices = static_cast<std::uint32_t>(row.integer(0)),
                          .n_bytes = static_cast<std::uint64_t>(row.integer(1)),
                          .psi = row.real(2),
                          .seconds = row.real(3)});
    return points;
}

bool SqliteCatalog::remove(const std::string& id) {
    const std::lock_guard lock(state_->mutex);
    state_->database.run("DELETE FROM model WHERE id = ?", id);
    return state_->database.n_changes() > 0;
}

bool SqliteCatalog::cancel(const std::string& id, Timestamp now) {
    const std::lock_guard lock(state_->mutex);
    state_->database.run(
        "UPDATE model SET state = 'cancelled', seconds_left = NULL, updated = ? "
        "WHERE id = ? AND state IN ('queued', 'running')",
        to_number(now), id);
    return state_->database.n_changes() > 0;
}

std::map<ModelState, std::size_t> SqliteCatalog::counts() {
    const std::lock_guard lock(state_->mutex);
    SqliteStatement row(state_->database, "SELECT state, count(*) FROM model GROUP BY state");
    std::map<ModelState, std::size_t> counts;
    while (row.next()) counts[state_of(row.text(0))] = static_cast<std::size_t>(row.integer(1));
    return counts;
}

std::vector<ModelRecord> SqliteCatalog::final_before(Timestamp before) {
    const std::lock_guard lock(state_->mutex);
    SqliteStatement row(
        state_->database,
        std::string("SELECT ") + record_columns +
            " FROM model WHERE state NOT IN ('queued', 'running') AND updated < ? ORDER BY updated, number",
        to_number(before));
    std::vector<ModelRecord> models;
    while (row.next()) models.push_back(read_record(row));
    return models;
}

std::optional<ModelRecord> SqliteCatalog::claim_next(Timestamp now, Timestamp lease_until) {
    // An attempt is put off by seconds. One that lies further ahead was put off before the clock was set back.
    constexpr auto longest_delay = std::chrono::minutes(10);
    const std::lock_guard lock(state_->mutex);
    return state_->database.transaction([&]() -> std::optional<ModelRecord> {
        std::string id;
        {
            SqliteStatement row(state_->database,
                                "SELECT id FROM model WHERE state = 'queued' AND (not_before <= ? OR not_before > ?) "
                                "ORDER BY fruitless, number LIMIT 1",
                                to_number(now), to_number(now + longest_delay));
            if (!row.next()) return std::nullopt;
            id = row.text(0);
        }
        state_->database.run(
            "UPDATE model SET state = 'running', attempts = attempts + 1, epoch = epoch + 1, lease_until = ?, "
            "stage = '', fraction = 0, seconds_left = NULL, error = '', updated = ? WHERE id = ?",
            to_number(lease_until), to_number(now), id);
        return state_->find(id);
    });
}

bool SqliteCatalog::renew(const Lease& lease, Timestamp lease_until) {
    const std::lock_guard lock(state_->mutex);
    return state_->run_leased("UPDATE model SET lease_until = ?", lease, to_number(lease_until));
}

bool SqliteCatalog::begin(const Lease& lease, std::uint64_t n_bytes, Timestamp now) {
    const std::lock_guard lock(state_->mutex);
    return state_->database.transaction([&] {
        if (!state_->holds(lease)) return false;
        state_->database.run(
            "DELETE FROM rate_point WHERE model = (SELECT number FROM model WHERE id = ?) AND bytes > ?", lease.id,
            n_bytes);
        const std::string last = " FROM rate_point WHERE model = model.number ORDER BY bytes DESC LIMIT 1)";
        state_->database.run("UPDATE model SET vertices = ifnull((SELECT vertices" + last +
                                 ", 0), bytes = ifnull((SELECT bytes" + last + ", 0), psi = (SELECT psi" + last +
                                 ", updated = ? WHERE id = ?",
                             to_number(now), lease.id);
        return true;
    });
}

bool SqliteCatalog::report(const Lease& lease, const JobProgress& progress, Timestamp now) {
    const std::lock_guard lock(state_->mutex);
    return state_->run_leased(
        "UPDATE model SET stage = ?, fraction = ?, vertices = ?, bytes = ?, psi = ?, seconds_left = ?, updated = ?",
        lease, progress.stage, progress.fraction, progress.n_vertices, progress.n_bytes, progress.psi,
        progress.seconds_left, to_number(now));
}

bool SqliteCatalog::add_rate_point(const Lease& lease, const RatePoint& point) {
    const std::lock_guard lock(state_->mutex);
    return state_->database.transaction([&] {
        if (!state_->run_leased(
                "UPDATE model SET fruitless = iif(? > reached, 0, fruitless), reached = max(reached, ?)", lease,
                point.n_bytes, point.n_bytes))
            return false;
        state_->database.run(
            "INSERT INTO rate_point (model, vertices, bytes, psi, seconds) "
            "SELECT number, ?, ?, ?, ? FROM model WHERE id = ?",
            point.n_vertices, point.n_bytes, point.psi, point.seconds, lease.id);
        return true;
    });
}

bool SqliteCatalog::finish(const Lease& lease, ModelState state, const std::string& error, Timestamp now) {
    const std::lock_guard lock(state_->mutex);
    return state_->run_leased("UPDATE model SET state = ?, error = ?, seconds_left = NULL, updated = ?", lease,
                              std::string(state_name(state)), error, to_number(now));
}

bool SqliteCatalog::retry(const Lease& lease, const RetryRule& rule, const std::string& error, Timestamp now) {
    const std::lock_guard lock(state_->mutex);
    state_->database.run(std::string(set_retried) + "WHERE id = ?6 AND epoch = ?7 AND state = 'running'",
                         rule.max_fruitless, rule.is_counted ? 1 : 0, error, to_number(rule.not_before), to_number(now),
                         lease.id, lease.epoch);
    return state_->database.n_changes() > 0;
}

bool SqliteCatalog::give_back(const Lease& lease, Timestamp now) {
    const std::lock_guard lock(state_->mutex);
    return state_->run_leased(
        "UPDATE model SET state = 'queued', attempts = attempts - 1, seconds_left = NULL, updated = ?", lease,
        to_number(now));
}

int SqliteCatalog::recover(Timestamp end, const RetryRule& rule, const std::string& error, Timestamp now) {
    const std::lock_guard lock(state_->mutex);
    state_->database.run(std::string(set_retried) + "WHERE state = 'running' AND lease_until <= ?6", rule.max_fruitless,
                         rule.is_counted ? 1 : 0, error, to_number(rule.not_before), to_number(now), to_number(end));
    return state_->database.n_changes();
}

void SqliteCatalog::back_up(const std::filesystem::path& file) {
    const std::lock_guard lock(state_->mutex);
    state_->database.back_up(file);
}

}  // namespace anyrate
