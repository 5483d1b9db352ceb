#include "server/store/catalog_format.h"

#include <array>
#include <cstddef>

#include "core/error.h"

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

std::int64_t format_of(const SqliteDatabase& catalog) {
    SqliteStatement row(catalog, "PRAGMA user_version");
    return row.next() ? row.integer(0) : 0;
}

}  // namespace

void bring_up_to_date(SqliteDatabase& catalog, const std::filesystem::path& file) {
    const std::int64_t version = format_of(catalog);
    if (version > format_version)
        throw InputError(file.string() + ": the data directory has format " + std::to_string(version) +
                         ", this program knows up to " + std::to_string(format_version));
    if (version == format_version) return;
    catalog.transaction([&] {
        for (auto step = static_cast<std::size_t>(version); step < steps.size(); ++step)
            catalog.run_script(steps[step]);
        catalog.run_script(("PRAGMA user_version = " + std::to_string(format_version)).c_str());
        return true;
    });
}

}  // namespace anyrate
