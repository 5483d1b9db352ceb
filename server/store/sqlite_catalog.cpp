#include "server/store/sqlite_catalog.h"

#include <sqlite3.h>

#include <array>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string_view>
#include <type_traits>

#include "core/error.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

constexpr int format_version = 2;  // of the data directory; kept in SQLite's user_version

constexpr const char* schema = R"sql(
    CREATE TABLE model (
        number INTEGER PRIMARY KEY AUTOINCREMENT,  -- order of arrival
        id TEXT NOT NULL UNIQUE,
        state TEXT NOT NULL,
        options TEXT NOT NULL,                     -- JSON, so that a new option needs no new format
        stage TEXT NOT NULL DEFAULT '',
        fraction REAL NOT NULL DEFAULT 0,
        vertices INTEGER NOT NULL DEFAULT 0,
        bytes INTEGER NOT NULL DEFAULT 0,
        psi REAL,
        error TEXT NOT NULL DEFAULT '',
        attempts INTEGER NOT NULL DEFAULT 0,
        created INTEGER NOT NULL,                  -- milliseconds since 1970
        updated INTEGER NOT NULL,
        idempotency_key TEXT UNIQUE,
        fingerprint TEXT NOT NULL DEFAULT '');
    CREATE INDEX model_by_state ON model (state, number);
    CREATE TABLE rate_point (
        model INTEGER NOT NULL REFERENCES model (number) ON DELETE CASCADE,
        vertices INTEGER NOT NULL,
        bytes INTEGER NOT NULL,
        psi REAL NOT NULL,
        seconds REAL NOT NULL);
    CREATE INDEX rate_point_by_model ON rate_point (model);
)sql";

/// Format 2 has leases.
constexpr const char* leases = R"sql(
    ALTER TABLE model ADD COLUMN epoch INTEGER NOT NULL DEFAULT 0;        -- of the latest lease
    ALTER TABLE model ADD COLUMN lease_until INTEGER NOT NULL DEFAULT 0;  -- milliseconds since 1970
    ALTER TABLE model ADD COLUMN fruitless INTEGER NOT NULL DEFAULT 0;    -- attempts since the curve last grew
    ALTER TABLE model ADD COLUMN reached INTEGER NOT NULL DEFAULT 0;      -- bytes, the most that the curve ever had
    ALTER TABLE model ADD COLUMN not_before INTEGER NOT NULL DEFAULT 0;   -- of the next attempt
    ALTER TABLE model ADD COLUMN seconds_left REAL;
)sql";

/// What each format adds to the one before.
constexpr std::array<const char*, format_version> steps = {schema, leases};

constexpr const char* record_columns =
    "id, state, options, stage, fraction, vertices, bytes, psi, error, attempts, created, updated, epoch, seconds_left";

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

[[noreturn]] void fail(sqlite3* database) {
    const std::string sentence = std::string("catalog: ") + sqlite3_errmsg(database);
    if (sqlite3_errcode(database) == SQLITE_FULL) throw DiskFull(sentence);
    throw IoError(sentence);
}

/// SQLite goes on with what it has in memory when the file under it is removed, replaced or overwritten; nothing of
/// that would be there after a restart.
void expect_in_place(sqlite3* database) {
    int has_moved = 0;
    sqlite3_file_control(database, "main", SQLITE_FCNTL_HAS_MOVED, &has_moved);
    if (has_moved) throw IoError("catalog: its file was removed or replaced");
    constexpr std::string_view signature = "SQLite format 3";
    const auto begin = read_at(open_if_exists(sqlite3_db_filename(database, "main")), 0, signature.size());
    if (as_text(begin) != signature) throw IoError("catalog: its file does not begin as a database does");
}

/// One prepared statement with its values bound, stepped row by row.
class Statement {
public:
    template <class... Values>
    Statement(sqlite3* database, const std::string& sql, const Values&... values) : database_(database) {
        check(sqlite3_prepare_v2(database, sql.c_str(), -1, &statement_, nullptr));
        [[maybe_unused]] int position = 0;
        (bind(++position, values), ...);
    }
    ~Statement() { sqlite3_finalize(statement_); }
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    bool next() {
        const int code = sqlite3_step(statement_);
        if (code == SQLITE_ROW) return true;
        if (code != SQLITE_DONE) check(code);
        return false;
    }
    std::int64_t integer(int column) { return sqlite3_column_int64(statement_, column); }
    double real(int column) { return sqlite3_column_double(statement_, column); }
    bool is_null(int column) { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
    std::string text(int column) {
        const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
        return {bytes ? bytes : "", static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
    }

private:
    template <class Value>
    void bind(int position, const Value& value) {
        if constexpr (std::is_same_v<Value, std::nullopt_t>)
            check(sqlite3_bind_null(statement_, position));
        else if constexpr (std::is_floating_point_v<Value>)
            check(sqlite3_bind_double(statement_, position, value));
        else if constexpr (std::is_integral_v<Value>)
            check(sqlite3_bind_int64(statement_, position, static_cast<std::int64_t>(value)));
        else
            bind_text(position, value);
    }
    void bind(int position, const std::optional<double>& value) {
        if (value)
            bind(position, *value);
        else
            bind(position, std::nullopt);
    }
    void bind_text(int position, const std::string& text) {
        check(sqlite3_bind_text(statement_, position, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT));
    }
    void check(int code) const {
        if (code != SQLITE_OK) fail(database_);
    }

    sqlite3* database_;
    sqlite3_stmt* statement_ = nullptr;
};

ModelRecord read_record(Statement& row) {
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
    return record;
}

}  // namespace

struct SqliteCatalog::Database {
    sqlite3* handle = nullptr;
    std::mutex mutex;

    ~Database() { sqlite3_close(handle); }

    template <class... Values>
    void run(const std::string& sql, const Values&... values) {
        Statement(handle, sql, values...).next();
    }
    void run_script(const char* sql) {
        if (sqlite3_exec(handle, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail(handle);
    }
    /// All of `body` happens, or nothing.
    template <class Body>
    auto transaction(const Body& body) {
        run_script("BEGIN IMMEDIATE");
        try {
            auto result = body();
            run_script("COMMIT");
            return result;
        } catch (...) {
            sqlite3_exec(handle, "ROLLBACK", nullptr, nullptr, nullptr);
            throw;
        }
    }
    int n_changes() const { return sqlite3_changes(handle); }
    /// Changes the model of a lease, if that holds: the last two values of the statement are id and epoch.
    template <class... Values>
    bool run_leased(const std::string& sql, const Lease& lease, const Values&... values) {
        run(sql + " WHERE id = ? AND epoch = ? AND state = 'running'", values..., lease.id, lease.epoch);
        return n_changes() > 0;
    }
    bool holds(const Lease& lease) {
        return Statement(handle, "SELECT 1 FROM model WHERE id = ? AND epoch = ? AND state = 'running'", lease.id,
                         lease.epoch)
            .next();
    }
    std::optional<ModelRecord> find(const std::string& id) {
        Statement row(handle, std::string("SELECT ") + record_columns + " FROM model WHERE id = ?", id);
        return row.next() ? std::optional(read_record(row)) : std::nullopt;
    }
    void migrate(const std::filesystem::path& file) {
        std::int64_t version = 0;
        {
            Statement row(handle, "PRAGMA user_version");
            version = row.next() ? row.integer(0) : 0;
        }
        if (version > format_version)
            throw InputError(file.string() + ": the data directory has format " + std::to_string(version) +
                             ", this program knows up to " + std::to_string(format_version));
        if (version == format_version) return;
        transaction([&] {
            for (auto step = static_cast<std::size_t>(version); step < steps.size(); ++step) run_script(steps[step]);
            run_script(("PRAGMA user_version = " + std::to_string(format_version)).c_str());
            return true;
        });
    }
};

SqliteCatalog::SqliteCatalog(const std::filesystem::path& file) : database_(std::make_unique<Database>()) {
    if (sqlite3_open(file.c_str(), &database_->handle) != SQLITE_OK)
        throw IoError("cannot open the catalog " + file.string() + ": " + sqlite3_errmsg(database_->handle));
    sqlite3_busy_timeout(database_->handle, 5000);
    // FULL: an acknowledged upload survives a power cut, not only a crash of the process.
    database_->run_script("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON");
    database_->migrate(file);
}

SqliteCatalog::~SqliteCatalog() = default;

Added SqliteCatalog::add(const NewModel& model, Timestamp now) {
    const std::lock_guard lock(database_->mutex);
    return database_->transaction([&]() -> Added {
        if (!model.idempotency_key.empty()) {
            Statement row(database_->handle, "SELECT id, fingerprint FROM model WHERE idempotency_key = ?",
                          model.idempotency_key);
            if (row.next())
                return {row.text(1) == model.request_fingerprint ? Added::Kind::repeated : Added::Kind::key_reused,
                        row.text(0)};
        }
        database_->run(
            "INSERT INTO model (id, state, options, created, updated, idempotency_key, fingerprint) "
            "VALUES (?, 'queued', ?, ?, ?, nullif(?, ''), ?)",
            model.id, options_to_json(model.options), to_number(now), to_number(now), model.idempotency_key,
            model.request_fingerprint);
        return {Added::Kind::made, model.id};
    });
}

std::optional<ModelRecord> SqliteCatalog::find(const std::string& id) {
    const std::lock_guard lock(database_->mutex);
    return database_->find(id);
}

ModelPage SqliteCatalog::list(std::size_t limit, const std::string& after) {
    const std::lock_guard lock(database_->mutex);
    expect_in_place(database_->handle);
    Statement row(database_->handle,
                  std::string("SELECT ") + record_columns +
                      " FROM model WHERE ? = '' OR number < (SELECT number FROM model WHERE id = ?)"
                      " ORDER BY number DESC LIMIT ?",
                  after, after, limit + 1);
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
    const std::lock_guard lock(database_->mutex);
    Statement row(database_->handle,
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
    const std::lock_guard lock(database_->mutex);
    database_->run("DELETE FROM model WHERE id = ?", id);
    return database_->n_changes() > 0;
}

bool SqliteCatalog::cancel(const std::string& id, Timestamp now) {
    const std::lock_guard lock(database_->mutex);
    database_->run(
        "UPDATE model SET state = 'cancelled', seconds_left = NULL, updated = ? "
        "WHERE id = ? AND state IN ('queued', 'running')",
        to_number(now), id);
    return database_->n_changes() > 0;
}

std::map<ModelState, std::size_t> SqliteCatalog::counts() {
    const std::lock_guard lock(database_->mutex);
    Statement row(database_->handle, "SELECT state, count(*) FROM model GROUP BY state");
    std::map<ModelState, std::size_t> counts;
    while (row.next()) counts[state_of(row.text(0))] = static_cast<std::size_t>(row.integer(1));
    return counts;
}

std::vector<ModelRecord> SqliteCatalog::final_before(Timestamp before) {
    const std::lock_guard lock(database_->mutex);
    Statement row(database_->handle,
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
    const std::lock_guard lock(database_->mutex);
    return database_->transaction([&]() -> std::optional<ModelRecord> {
        std::string id;
        {
            Statement row(database_->handle,
                          "SELECT id FROM model WHERE state = 'queued' AND (not_before <= ? OR not_before > ?) "
                          "ORDER BY number LIMIT 1",
                          to_number(now), to_number(now + longest_delay));
            if (!row.next()) return std::nullopt;
            id = row.text(0);
        }
        database_->run(
            "UPDATE model SET state = 'running', attempts = attempts + 1, epoch = epoch + 1, lease_until = ?, "
            "stage = '', fraction = 0, seconds_left = NULL, error = '', updated = ? WHERE id = ?",
            to_number(lease_until), to_number(now), id);
        return database_->find(id);
    });
}

bool SqliteCatalog::renew(const Lease& lease, Timestamp lease_until) {
    const std::lock_guard lock(database_->mutex);
    return database_->run_leased("UPDATE model SET lease_until = ?", lease, to_number(lease_until));
}

bool SqliteCatalog::begin(const Lease& lease, std::uint64_t n_bytes, Timestamp now) {
    const std::lock_guard lock(database_->mutex);
    return database_->transaction([&] {
        if (!database_->holds(lease)) return false;
        database_->run("DELETE FROM rate_point WHERE model = (SELECT number FROM model WHERE id = ?) AND bytes > ?",
                       lease.id, n_bytes);
        const std::string last = " FROM rate_point WHERE model = model.number ORDER BY bytes DESC LIMIT 1)";
        database_->run("UPDATE model SET vertices = ifnull((SELECT vertices" + last +
                           ", 0), bytes = ifnull((SELECT bytes" + last + ", 0), psi = (SELECT psi" + last +
                           ", updated = ? WHERE id = ?",
                       to_number(now), lease.id);
        return true;
    });
}

bool SqliteCatalog::report(const Lease& lease, const JobProgress& progress, Timestamp now) {
    const std::lock_guard lock(database_->mutex);
    return database_->run_leased(
        "UPDATE model SET stage = ?, fraction = ?, vertices = ?, bytes = ?, psi = ?, seconds_left = ?, updated = ?",
        lease, progress.stage, progress.fraction, progress.n_vertices, progress.n_bytes, progress.psi,
        progress.seconds_left, to_number(now));
}

bool SqliteCatalog::add_rate_point(const Lease& lease, const RatePoint& point) {
    const std::lock_guard lock(database_->mutex);
    return database_->transaction([&] {
        if (!database_->run_leased(
                "UPDATE model SET fruitless = iif(? > reached, 0, fruitless), reached = max(reached, ?)", lease,
                point.n_bytes, point.n_bytes))
            return false;
        database_->run(
            "INSERT INTO rate_point (model, vertices, bytes, psi, seconds) "
            "SELECT number, ?, ?, ?, ? FROM model WHERE id = ?",
            point.n_vertices, point.n_bytes, point.psi, point.seconds, lease.id);
        return true;
    });
}

bool SqliteCatalog::finish(const Lease& lease, ModelState state, const std::string& error, Timestamp now) {
    const std::lock_guard lock(database_->mutex);
    return database_->run_leased("UPDATE model SET state = ?, error = ?, seconds_left = NULL, updated = ?", lease,
                                 std::string(state_name(state)), error, to_number(now));
}

bool SqliteCatalog::retry(const Lease& lease, const RetryRule& rule, const std::string& error, Timestamp now) {
    const std::lock_guard lock(database_->mutex);
    database_->run(std::string(set_retried) + "WHERE id = ?6 AND epoch = ?7 AND state = 'running'", rule.max_fruitless,
                   rule.is_counted ? 1 : 0, error, to_number(rule.not_before), to_number(now), lease.id, lease.epoch);
    return database_->n_changes() > 0;
}

bool SqliteCatalog::give_back(const Lease& lease, Timestamp now) {
    const std::lock_guard lock(database_->mutex);
    return database_->run_leased(
        "UPDATE model SET state = 'queued', attempts = attempts - 1, seconds_left = NULL, updated = ?", lease,
        to_number(now));
}

int SqliteCatalog::recover(Timestamp end, const RetryRule& rule, const std::string& error, Timestamp now) {
    const std::lock_guard lock(database_->mutex);
    database_->run(std::string(set_retried) + "WHERE state = 'running' AND lease_until <= ?6", rule.max_fruitless,
                   rule.is_counted ? 1 : 0, error, to_number(rule.not_before), to_number(now), to_number(end));
    return database_->n_changes();
}

void SqliteCatalog::back_up(const std::filesystem::path& file) {
    Database copy;
    if (sqlite3_open(file.c_str(), &copy.handle) != SQLITE_OK)
        throw IoError("cannot make " + file.string() + ": " + sqlite3_errmsg(copy.handle));
    const std::lock_guard lock(database_->mutex);
    sqlite3_backup* backup = sqlite3_backup_init(copy.handle, "main", database_->handle, "main");
    if (!backup) fail(copy.handle);
    const int copied = sqlite3_backup_step(backup, -1);
    const int finished = sqlite3_backup_finish(backup);
    if (copied != SQLITE_DONE || finished != SQLITE_OK) fail(copy.handle);
}

}  // namespace anyrate
