#include "server/jobs/housekeeping.h"

#include <doctest/doctest.h>

#include <chrono>
#include <condition_variable>
#include <set>

#include "server/store/file.h"
#include "server/store/model_store.h"
#include "server/store/sqlite_catalog.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;
using namespace std::chrono_literals;

namespace {

constexpr std::size_t model_bytes = 1000;

Timestamp at(std::chrono::milliseconds time) { return Timestamp(time); }

/// A data directory with models that became final at given times.
struct Fixture {
    TemporaryFolder folder;
    ModelStore store{folder.path()};
    SqliteCatalog catalog{store.catalog_file()};

    std::string queued() {
        const std::string id = new_model_id();
        replace_file(store.upload_file("u"), std::vector<std::byte>(model_bytes));
        store.adopt_upload(store.upload_file("u"), id);
        catalog.add({.id = id, .options = {}, .idempotency_key = "", .request_fingerprint = ""}, {});
        return id;
    }
    std::string final_at(Timestamp time) {
        const std::string id = queued();
        catalog.finish(lease_of(catalog.claim_next({}).value()), ModelState::done, "", time);
        return id;
    }
    bool has_files(const std::string& id) const { return std::filesystem::exists(store.paths(id).folder); }
    void clear_by(const KeepRule& rule, Timestamp now) {
        clear(catalog, find_clearing(catalog, folder.path(), rule, now), folder.path(), [](const std::string&) {});
    }
};

void make_old(const std::filesystem::path& path) {
    std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() - 2h);
}

}  // namespace

TEST_CASE("Clearing: without a rule nothing goes that is known") {
    Fixture f;
    const std::string id = f.final_at(at(1ms));
    make_old(f.store.paths(id).folder);
    f.clear_by({}, at(1'000'000h));
    CHECK(f.catalog.find(id));
    CHECK(f.has_files(id));
}

TEST_CASE("Clearing: by age the older final models go, never one that is queued or running") {
    Fixture f;
    const std::string old = f.final_at(at(1h)), young = f.final_at(at(9h)), running = f.queued(), waiting = f.queued();
    f.catalog.claim_next({});
    std::vector<std::string> removed;
    const Clearing clearing = find_clearing(f.catalog, f.folder.path(), {.age = 5h, .bytes = {}}, at(10h));
    CHECK(clearing.models == std::vector<std::string>{old});
    CHECK(clearing.n_bytes == model_bytes);
    CHECK(f.has_files(old));  // nothing is removed by looking
    clear(f.catalog, clearing, f.folder.path(), [&](const std::string& id) { removed.push_back(id); });
    CHECK(removed == std::vector<std::string>{old});
    CHECK_FALSE(f.catalog.find(old));
    CHECK_FALSE(f.has_files(old));
    for (const std::string& id : {young, running, waiting}) {
        CHECK(f.catalog.find(id));
        CHECK(f.has_files(id));
    }
}

TEST_CASE("Clearing: by size the oldest final models go until the rest fits") {
    Fixture f;
    const std::string second = f.final_at(at(2h)), first = f.final_at(at(1h)), third = f.final_at(at(3h));
    f.queued();
    f.clear_by({.age = {}, .bytes = 2 * model_bytes + model_bytes / 2}, at(10h));
    CHECK_FALSE(f.catalog.find(first));
    CHECK_FALSE(f.catalog.find(second));
    CHECK(f.catalog.find(third));
    f.clear_by({.age = {}, .bytes = 0}, at(10h));
    CHECK(f.catalog.list(10, Catalog::from_newest).models.size() == 1);  // the queued one, however large
}

TEST_CASE("Clearing: leftovers of a crash go once they are old") {
    Fixture f;
    const auto folder = f.folder.path() / "models" / std::string(26, 'b'),
               upload = f.folder.path() / "uploads" / "half";
    std::filesystem::create_directories(folder);
    replace_file(upload, as_bytes("PK"));
    f.clear_by({}, at(0ms));
    CHECK(std::filesystem::exists(folder));  // somebody may be about to enter it
    CHECK(std::filesystem::exists(upload));
    make_old(folder);
    make_old(upload);
    f.clear_by({}, at(0ms));
    CHECK_FALSE(std::filesystem::exists(folder));
    CHECK_FALSE(std::filesystem::exists(upload));
}

TEST_CASE("Housekeeper: clears by itself, and ends at once") {
    Fixture f;
    const std::string id = f.final_at(at(1ms));
    std::mutex mutex;
    std::condition_variable cleared;
    std::string removed;
    {
        Housekeeper housekeeper(
            f.catalog, f.folder.path(), {.age = 1h, .bytes = {}}, 1h,
            [&](const std::string& gone) {
                const std::lock_guard lock(mutex);
                removed = gone;
                cleared.notify_all();
            },
            [](const std::string&) {});
        std::unique_lock lock(mutex);
        CHECK(cleared.wait_for(lock, 60s, [&] { return removed == id; }));
    }
    CHECK_FALSE(f.has_files(id));
}
