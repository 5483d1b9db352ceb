#include "server/jobs/scheduler.h"

#include <doctest/doctest.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <future>
#include <mutex>
#include <thread>

#include "server/store/sqlite_catalog.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

/// A scheduler whose workers are shell scripts.
struct Fixture {
    TemporaryFolder folder;
    SqliteCatalog catalog{folder.path() / "catalog.sqlite"};
    ModelEvents events;

    SchedulerOptions options{.n_workers = 1,
                             .max_attempts = 3,
                             .stop_patience = std::chrono::milliseconds(2000),
                             .retry_delay = std::chrono::milliseconds(10),
                             .room_delay = std::chrono::milliseconds(10)};

    std::string add() {
        const std::string id = new_model_id();
        catalog.add({.id = id, .options = {}, .idempotency_key = "", .request_fingerprint = ""}, {});
        return id;
    }
    WorkerCommand shell(const std::string& script) {
        return [script](const ModelRecord& model) -> std::vector<std::string> {
            return {"/bin/sh",
                    "-c",
                    script,
                    "worker",
                    model.id,
                    std::to_string(model.attempts),
                    std::to_string(model.epoch)};
        };
    }
    ModelRecord wait_for(const std::string& id, const std::function<bool(const ModelRecord&)>& is_reached) {
        for (int i = 0; i < 2000; ++i) {
            const ModelRecord model = catalog.find(id).value();
            if (is_reached(model)) return model;
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return catalog.find(id).value();
    }
    ModelRecord run(const std::string& script) {
        const std::string id = add();
        Scheduler scheduler(catalog, events, shell(script), options, [](const std::string&) {});
        return wait_for(id, [](const ModelRecord& model) { return is_final(model.state); });
    }
};

const std::string done = "echo '{\"type\":\"done\"}'";

}  // namespace

TEST_CASE("Scheduler: what a worker reports stands in the catalog") {
    Fixture f;
    const ModelRecord model = f.run(
        "echo '{\"type\":\"progress\",\"stage\":\"refine\",\"fraction\":0.5,\"vertices\":7,\"bytes\":8,\"psi\":1.5}';"
        "echo '{\"type\":\"rate\",\"vertices\":7,\"bytes\":8,\"psi\":1.5,\"seconds\":0.1}';" +
        done);
    CHECK(model.state == ModelState::done);
    CHECK(model.progress == JobProgress{"refine", 0.5, 7, 8, 1.5});
    CHECK(f.catalog.curve(model.id).size() == 1);
}

TEST_CASE("Scheduler: a failed capture is not tried again") {
    Fixture f;
    const ModelRecord model =
        f.run("echo '{\"type\":\"failed\",\"error\":\"no cameras\",\"cause\":\"capture\"}'; exit 1");
    CHECK(model.state == ModelState::failed);
    CHECK(model.error == "no cameras");
    CHECK(model.attempts == 1);
}

TEST_CASE("Scheduler: a worker that dies is started again, up to the limit") {
    Fixture f;
    CHECK(f.run("[ $2 = 3 ] || kill -9 $$; " + done).attempts == 3);
    const ModelRecord model = f.run("kill -9 $$");
    CHECK(model.state == ModelState::failed);
    CHECK(model.error == "the worker process ended with signal 9");
}

TEST_CASE("Scheduler: a worker does not learn the server's token") {
    Fixture f;
    ::setenv("ANYRATE_TOKEN", "secret", 1);
    ::setenv("ANYRATE_OTHER", "thing", 1);
    const ModelRecord model = f.run("[ -z \"$ANYRATE_TOKEN\" ] && [ \"$ANYRATE_OTHER\" = thing ] && " + done);
    ::unsetenv("ANYRATE_TOKEN");
    ::unsetenv("ANYRATE_OTHER");
    CHECK(model.state == ModelState::done);
}

TEST_CASE("Scheduler: noise on a worker's output does no harm") {
    Fixture f;
    CHECK(f.run("echo noise; echo '{\"type\":7}'; " + done).state == ModelState::done);
}

TEST_CASE("Scheduler: a worker beyond its time is killed and its model fails") {
    Fixture f;
    f.options.job_limit = std::chrono::milliseconds(200);
    const ModelRecord model = f.run("exec sleep 60");
    CHECK(model.state == ModelState::failed);
    CHECK(model.attempts == 1);
}

TEST_CASE("Scheduler: stopping gives the model back without counting the attempt") {
    Fixture f;
    const std::string id = f.add();
    {
        Scheduler scheduler(f.catalog, f.events, f.shell("exec sleep 60"), f.options, [](const std::string&) {});
        f.wait_for(id, [](const ModelRecord& model) { return model.state == ModelState::running; });
    }
    CHECK(f.catalog.find(id)->state == ModelState::queued);
    CHECK(f.catalog.find(id)->attempts == 0);
}

TEST_CASE("Scheduler: a model that a dead server left running is run again") {
    Fixture f;
    const std::string id = f.add();
    f.catalog.claim_next({});
    Scheduler scheduler(f.catalog, f.events, f.shell(done), f.options, [](const std::string&) {});
    const auto model = f.wait_for(id, [](const ModelRecord& m) { return is_final(m.state); });
    CHECK(model.state == ModelState::done);
    CHECK(model.attempts == 2);
}

TEST_CASE("Scheduler: a clock that is set forward takes no job from its worker") {
    Fixture f;
    std::atomic<std::int64_t> hours = 0;
    f.options.n_workers = 2;  // one looks for leases that ran out while the other works
    f.options.lease = std::chrono::milliseconds(1500);
    f.options.clock = [&] { return wall_clock() + std::chrono::hours(hours); };
    const std::string id = f.add();
    const auto file = f.folder.path() / "go on";
    Scheduler scheduler(f.catalog, f.events,
                        f.shell("while ! [ -e '" + file.string() + "' ]; do sleep 0.05; done; " + done), f.options,
                        [](const std::string&) {});
    f.wait_for(id, [](const ModelRecord& m) { return m.state == ModelState::running; });
    hours = 5;
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // the other has looked once or twice
    std::ofstream(file) << "now";
    const auto model = f.wait_for(id, [](const ModelRecord& m) { return is_final(m.state); });
    CHECK(model.state == ModelState::done);
    CHECK(model.attempts == 1);
}

TEST_CASE("Scheduler: an abandoned model's worker is gone when the call returns") {
    Fixture f;
    const std::string id = f.add();
    const auto file = f.folder.path() / "pid";
    Scheduler scheduler(f.catalog, f.events, f.shell("echo $$ > " + file.string() + "; exec sleep 60"), f.options,
                        [](const std::string&) {});
    for (int i = 0; i < 2000 && !std::filesystem::exists(file); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // the shell has written by then
    f.catalog.remove(id);
    scheduler.abandon(id);
    std::string pid;
    std::ifstream(file) >> pid;
    CHECK_FALSE(std::filesystem::exists("/proc/" + pid));
}

TEST_CASE("Scheduler: a model removed between its claim and its start gets no worker") {
    Fixture f;
    const std::string id = f.add();
    const auto file = f.folder.path() / "started";
    std::promise<void> claimed, removed;
    {
        Scheduler scheduler(
            f.catalog, f.events,
            [&](const ModelRecord&) -> std::vector<std::string> {
                claimed.set_value();
                removed.get_future().wait();
                return {"/bin/sh", "-c", "touch " + file.string()};
            },
            f.options, [](const std::string&) {});
        claimed.get_future().wait();
        f.catalog.remove(id);
        scheduler.abandon(id);
        removed.set_value();
    }
    CHECK_FALSE(std::filesystem::exists(file));
}

TEST_CASE("Scheduler: a job that gets further at each attempt is tried for as long as it does") {
    Fixture f;
    const ModelRecord model = f.run(
        "echo '{\"type\":\"begun\",\"bytes\":'$2'}';"
        "echo '{\"type\":\"rate\",\"vertices\":7,\"bytes\":'$2'0,\"psi\":1,\"seconds\":1}';"
        "[ $2 -lt 8 ] && kill -9 $$; " +
        done);
    CHECK(model.state == ModelState::done);
    CHECK(model.attempts == 8);
}

TEST_CASE("Scheduler: a job whose disk fails for a while is tried again longer than one whose worker dies") {
    Fixture f;
    const std::string failed = "echo '{\"type\":\"failed\",\"error\":\"no disk\",\"cause\":\"machine\"}'; exit 1";
    const ModelRecord model = f.run("if [ $2 -lt 9 ]; then " + failed + "; fi; [ $2 -gt 10 ] || kill -9 $$; " + done);
    CHECK(model.state == ModelState::done);
    CHECK(model.attempts == 11);
    f.options.max_restarts = 4;
    const ModelRecord lost = f.run(failed);
    CHECK(lost.state == ModelState::failed);
    CHECK(lost.error == "no disk");
    CHECK(lost.attempts == 7);  // four that may, and three in a row
}

TEST_CASE("Scheduler: a job that finds the disk full waits for room, however often") {
    Fixture f;
    const ModelRecord model = f.run(
        "[ $2 -lt 7 ] && echo '{\"type\":\"failed\",\"error\":\"full\",\"cause\":\"no room\"}' && exit 1; " + done);
    CHECK(model.state == ModelState::done);
    CHECK(model.attempts == 7);
}

TEST_CASE("Scheduler: a cancelled model's worker is killed, and what it says later is not heard") {
    Fixture f;
    const std::string id = f.add();
    Scheduler scheduler(f.catalog, f.events, f.shell("sleep 0.3; " + done + "; exec sleep 60"), f.options,
                        [](const std::string&) {});
    f.wait_for(id, [](const ModelRecord& model) { return model.state == ModelState::running; });
    f.catalog.cancel(id, {});
    scheduler.abandon(id);
    const std::string next = f.add();  // the slot is free again
    scheduler.wake();
    CHECK(f.wait_for(next, [](const ModelRecord& model) { return model.state == ModelState::running; }).state ==
          ModelState::running);
    CHECK(f.catalog.find(id)->state == ModelState::cancelled);
}

TEST_CASE("Scheduler: a long job keeps its lease") {
    Fixture f;
    f.options.lease = std::chrono::milliseconds(300);
    const ModelRecord model = f.run("sleep 1.5; " + done);
    CHECK(model.state == ModelState::done);
    CHECK(model.attempts == 1);
}

TEST_CASE("Scheduler: a lease that ran out is given to another worker") {
    Fixture f;
    const std::string id = f.add();
    Scheduler scheduler(f.catalog, f.events, f.shell(done), f.options, [](const std::string&) {});
    f.wait_for(id, [](const ModelRecord& model) { return is_final(model.state); });
    // As if the end of an attempt could not be written down: somebody holds a lease, but nobody works.
    SqliteCatalog other(f.folder.path() / "catalog.sqlite");
    const std::string lost = f.add();
    const auto taken = other.claim_next(Timestamp(std::chrono::hours(24 * 365 * 200)), Timestamp());
    scheduler.wake();
    const ModelRecord model = f.wait_for(lost, [](const ModelRecord& m) { return is_final(m.state); });
    CHECK(model.state == ModelState::done);
}

TEST_CASE("Scheduler: each stage's time is told") {
    Fixture f;
    std::mutex mutex;
    std::vector<std::string> stages;
    f.options.on_stage = [&](const std::string& stage, double seconds) {
        const std::lock_guard lock(mutex);
        if (seconds >= 0) stages.push_back(stage);
    };
    const auto progress = [](const std::string& stage) {
        return "echo '{\"type\":\"progress\",\"stage\":\"" + stage +
               "\",\"fraction\":0.5,\"vertices\":7,\"bytes\":8}';";
    };
    f.run(progress("load") + progress("hull") + progress("hull") + progress("seal") + done);
    const std::lock_guard lock(mutex);
    CHECK(stages == std::vector<std::string>{"load", "hull", "seal"});
}
