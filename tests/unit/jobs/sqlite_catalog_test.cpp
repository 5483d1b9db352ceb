// What the contract of every catalog does not say: how the file's format grows, and that it is seen by others.
#include "server/store/sqlite_catalog.h"

#include <doctest/doctest.h>
#include <sqlite3.h>

#include <string>

#include "core/error.h"
#include "server/store/file.h"
#include "server/store/model_id.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

void run(const std::filesystem::path& file, const std::string& sql) {
    sqlite3* database = nullptr;
    REQUIRE(sqlite3_open(file.c_str(), &database) == SQLITE_OK);
    const int code = sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr);
    sqlite3_close(database);
    REQUIRE(code == SQLITE_OK);
}

/// A catalog as format 1 had it, with a model that is done and one that was running.
constexpr const char* format_1 = R"sql(
    CREATE TABLE model (
        number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, state TEXT NOT NULL, options TEXT NOT NULL,
        stage TEXT NOT NULL DEFAULT '', fraction REAL NOT NULL DEFAULT 0, vertices INTEGER NOT NULL DEFAULT 0,
        bytes INTEGER NOT NULL DEFAULT 0, psi REAL, error TEXT NOT NULL DEFAULT '', attempts INTEGER NOT NULL DEFAULT 0,
        created INTEGER NOT NULL, updated INTEGER NOT NULL, idempotency_key TEXT UNIQUE,
        fingerprint TEXT NOT NULL DEFAULT '');
    CREATE INDEX model_by_state ON model (state, number);
    CREATE TABLE rate_point (
        model INTEGER NOT NULL REFERENCES model (number) ON DELETE CASCADE,
        vertices INTEGER NOT NULL, bytes INTEGER NOT NULL, psi REAL NOT NULL, seconds REAL NOT NULL);
    CREATE INDEX rate_point_by_model ON rate_point (model);
    INSERT INTO model (id, state, options, vertices, bytes, psi, created, updated)
        VALUES ('aaaaaaaaaaaaaaaaaaaaaaaaaa', 'done', '{"vertices":900,"coarse":400}', 900, 5000, 7.5, 1, 2);
    INSERT INTO rate_point VALUES (1, 900, 5000, 7.5, 3.5);
    INSERT INTO model (id, state, options, attempts, created, updated)
        VALUES ('bbbbbbbbbbbbbbbbbbbbbbbbbb', 'running', '{"vertices":900,"coarse":400}', 1, 3, 4);
    PRAGMA user_version = 1;
)sql";

}  // namespace

TEST_CASE("Sqlite catalog: a file of the first format is taken over with all it has") {
    TemporaryFolder folder;
    const auto file = folder.path() / "catalog.sqlite";
    run(file, format_1);
    {
        SqliteCatalog catalog(file);
        const ModelRecord done = catalog.find(std::string(26, 'a')).value();
        CHECK(done.state == ModelState::done);
        CHECK(done.options == ModelOptions{900, 400});
        CHECK(catalog.curve(done.id) == std::vector<RatePoint>{{900, 5000, 7.5, 3.5}});
        CHECK(catalog.recover(Timestamp::max(), {}, "", {}) == 1);
        const ModelRecord running = catalog.claim_next({}).value();
        CHECK(running.id == std::string(26, 'b'));
        CHECK(running.attempts == 2);
        CHECK(running.epoch == 1);
    }
    CHECK_NOTHROW(SqliteCatalog(file).find(std::string(26, 'a')).value());
}

TEST_CASE("Sqlite catalog: a file of a newer format is refused and left as it is") {
    TemporaryFolder folder;
    const auto file = folder.path() / "catalog.sqlite";
    run(file, "CREATE TABLE future (x); PRAGMA user_version = 99");
    CHECK_THROWS_WITH_AS(SqliteCatalog{file}, doctest::Contains("has format 99"), InputError);
    run(file, "INSERT INTO future VALUES (1)");
}

TEST_CASE("Sqlite catalog: what is no database is refused with a sentence") {
    TemporaryFolder folder;
    const auto file = folder.path() / "catalog.sqlite";
    replace_file(file, std::vector<std::byte>(5000, std::byte{7}));
    CHECK_THROWS_AS(SqliteCatalog{file}, IoError);
}

TEST_CASE("Sqlite catalog: two programs see each other's changes at once") {
    TemporaryFolder folder;
    const auto file = folder.path() / "catalog.sqlite";
    SqliteCatalog one(file), other(file);
    const std::string id = new_model_id();
    one.add({.id = id, .options = {}, .idempotency_key = "", .request_fingerprint = ""}, {});
    CHECK(other.find(id));
    CHECK(other.claim_next({})->id == id);
    CHECK_FALSE(one.claim_next({}));
    CHECK(one.remove(id));
    CHECK_FALSE(other.find(id));
}
