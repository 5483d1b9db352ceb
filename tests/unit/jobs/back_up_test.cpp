#include "server/jobs/back_up.h"

#include <doctest/doctest.h>

#include <stop_token>
#include <thread>

#include "core/error.h"
#include "proto/log_reader.h"
#include "server/jobs/job_runner.h"
#include "server/store/directory_log_store.h"
#include "server/store/file.h"
#include "server/store/model_store.h"
#include "server/store/sqlite_catalog.h"
#include "tests/unit/server/small_model.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

struct Fixture {
    TemporaryFolder folder;
    std::filesystem::path data = folder.path() / "data", copy = folder.path() / "copy";
    ModelStore store{data};
    SqliteCatalog catalog{store.catalog_file()};
    DirectoryLogStore logs{data};

    std::string queued() {
        const std::string id = new_model_id();
        replace_file(store.upload_file("u"), as_bytes("PK capture"));
        store.adopt_upload(store.upload_file("u"), id);
        catalog.add({.id = id, .options = {}, .idempotency_key = "", .request_fingerprint = ""}, {});
        return id;
    }
    std::string finished() {
        const std::string id = queued();
        const Lease lease = lease_of(catalog.claim_next({}).value());
        run(id, lease, small_job_steps(3));
        catalog.finish(lease, ModelState::done, "", {});
        return id;
    }
    void run(const std::string& id, const Lease& lease, const JobSteps& steps) {
        run_job({.model_id = id, .capture = store.paths(id).capture, .options = {}, .epoch = lease.epoch}, steps, logs,
                [](const WorkerMessage&) {}, {});
    }
};

}  // namespace

TEST_CASE("Backup: everything is there, byte for byte, and a server can open it") {
    Fixture f;
    const std::string done = f.finished(), waiting = f.queued();
    replace_file(f.data / "tokens.json", as_bytes("[]"));
    std::filesystem::create_directories(f.data / "captures" / "x" / "images");
    replace_file(f.data / "captures" / "x" / "images" / "1.png", as_bytes("png"));
    const BackUp backup = back_up(f.data, f.copy);
    CHECK(backup.n_models == 2);
    const ModelStore store(f.copy);
    SqliteCatalog catalog(store.catalog_file());
    CHECK(catalog.find(done)->state == ModelState::done);
    CHECK(catalog.find(waiting)->state == ModelState::queued);
    CHECK(read_file(store.paths(done).sealed_log) == read_file(f.store.paths(done).sealed_log));
    CHECK(read_file(store.paths(done).live_log) == read_file(f.store.paths(done).live_log));
    CHECK(as_text(read_file(store.paths(waiting).capture)) == "PK capture");
    CHECK(as_text(read_file(f.copy / "tokens.json")) == "[]");
    CHECK(as_text(read_file(f.copy / "captures" / "x" / "images" / "1.png")) == "png");
}

TEST_CASE("Backup: of a job that was copied while it ran goes on in the copy, to the same model") {
    Fixture f;
    const std::string id = f.queued();
    const Lease lease = lease_of(f.catalog.claim_next({}).value());
    f.run(id, lease, small_job_steps(6, [&](int n) {
              if (n == 15) back_up(f.data, f.copy);
          }));
    const ModelStore store(f.copy);
    SqliteCatalog catalog(store.catalog_file());
    REQUIRE_FALSE(std::filesystem::exists(store.paths(id).sealed_log));
    catalog.recover(Timestamp::max(), {}, "", {});
    const Lease again = lease_of(catalog.claim_next({}).value());
    DirectoryLogStore logs(f.copy);
    std::uint64_t begun_at = 0;
    run_job({.model_id = id, .capture = store.paths(id).capture, .options = {}, .epoch = again.epoch},
            small_job_steps(6), logs,
            [&](const WorkerMessage& message) {
                if (const auto* begun = std::get_if<JobBegun>(&message)) begun_at = begun->n_bytes;
            },
            {});
    CHECK(begun_at > 0);
    CHECK(read_file(store.paths(id).sealed_log) == read_file(f.store.paths(id).sealed_log));
}

TEST_CASE("Backup: a lease that was given out since the catalog was copied keeps nobody out of the copy") {
    Fixture f;
    const std::string id = f.queued();
    f.catalog.claim_next({});
    f.logs.take(id, 7);  // as many attempts later
    back_up(f.data, f.copy);
    SqliteCatalog catalog(f.copy / "catalog.sqlite");
    catalog.recover(Timestamp::max(), {}, "", {});
    const Lease lease = lease_of(catalog.claim_next({}).value());
    CHECK(lease.epoch < 7);
    CHECK_NOTHROW(DirectoryLogStore(f.copy).take(id, lease.epoch));
}

TEST_CASE("Backup: whatever is written, finished and deleted meanwhile, what the copy lists is whole") {
    Fixture f;
    for (int i = 0; i < 10; ++i) f.finished();
    std::jthread busy([&](const std::stop_token& stop) {
        for (int i = 0; !stop.stop_requested(); ++i) {
            const std::string id = f.finished();
            if (i % 2 == 0) continue;
            f.catalog.remove(id);
            f.store.remove(id);
        }
    });
    for (int round = 0; round < 5; ++round) {
        const auto copy = f.folder.path() / ("copy" + std::to_string(round));
        back_up(f.data, copy);
        const ModelStore store(copy);
        SqliteCatalog catalog(store.catalog_file());
        const ModelPage page = catalog.list(1000, Catalog::from_newest);
        CHECK(page.models.size() >= 10);
        for (const ModelRecord& model : page.models) {
            CHECK(as_text(read_file(store.paths(model.id).capture)) == "PK capture");
            if (model.state == ModelState::done) CHECK(verify_log(read_file(store.paths(model.id).sealed_log)) > 0);
        }
    }
}

TEST_CASE("Backup: an existing folder is not touched, and what is no data directory is refused") {
    Fixture f;
    std::filesystem::create_directories(f.copy);
    CHECK_THROWS_AS(back_up(f.data, f.copy), InputError);
    CHECK_THROWS_AS(back_up(f.folder.path(), f.folder.path() / "other"), InputError);
    CHECK_FALSE(std::filesystem::exists(f.folder.path() / "other"));
}
