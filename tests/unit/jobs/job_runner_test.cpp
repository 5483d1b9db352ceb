#include "server/jobs/job_runner.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <new>
#include <string>
#include <vector>

#include "core/error.h"
#include "proto/log_reader.h"
#include "server/jobs/durable_sink.h"
#include "server/store/directory_log_store.h"
#include "server/store/model_store.h"
#include "tests/unit/server/small_model.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

/// As a worker that is killed: whatever was going on ends at once.
struct Killed {};

struct Fixture {
    TemporaryFolder folder;
    Job job;
    ModelPaths paths;
    DirectoryLogStore store{folder.path()};
    std::vector<WorkerMessage> messages;

    Fixture() {
        job.model_id = std::string(26, 'a');
        paths = model_paths(folder.path(), job.model_id);
        std::filesystem::create_directories(paths.folder);
    }
    WorkerMessage run(const JobSteps& steps, std::stop_token stop = {}) {
        run_job(
            job, steps, store, [&](const WorkerMessage& message) { messages.push_back(message); }, stop);
        return messages.back();
    }
    /// Runs until the mesh has so many vertices; then the worker is killed.
    void run_until(const JobSteps& steps) {
        CHECK_THROWS_AS(
            run_job(job, steps, store, [&](const WorkerMessage& message) { messages.push_back(message); }, {}), Killed);
        ++job.epoch;
    }
    template <class Error>
    JobFailed failure(const Error& error) {
        JobSteps steps = small_job_steps(1);
        steps.load = [&](const std::filesystem::path&) -> Capture { throw error; };
        return std::get<JobFailed>(run(steps));
    }
    std::vector<std::uint32_t> curve() const {
        std::vector<std::uint32_t> vertices;
        for (const WorkerMessage& message : messages)
            if (const auto* point = std::get_if<RatePoint>(&message)) vertices.push_back(point->n_vertices);
        return vertices;
    }
    std::uint64_t last_begin() const {
        for (auto message = messages.rbegin(); message != messages.rend(); ++message)
            if (const auto* begun = std::get_if<JobBegun>(&*message)) return begun->n_bytes;
        return ~0ull;
    }
};

JobSteps killed_at(int n_vertices, int n_batches = 5) {
    return small_job_steps(n_batches, [=](int n) {
        if (n == n_vertices) throw Killed();
    });
}

/// The sealed log of an undisturbed run with five batches, and its live log.
const std::pair<std::vector<std::byte>, std::vector<std::byte>>& undisturbed() {
    static const auto logs = [] {
        Fixture f;
        f.run(small_job_steps(5));
        return std::pair(read_file(f.paths.sealed_log), read_file(f.paths.live_log));
    }();
    return logs;
}

bool is_front_of(const std::vector<std::byte>& front, const std::vector<std::byte>& whole) {
    return front.size() <= whole.size() && std::equal(front.begin(), front.end(), whole.begin());
}

}  // namespace

TEST_CASE("Job: a model is sealed, sound, and its curve reported") {
    Fixture f;
    CHECK(std::holds_alternative<JobDone>(f.run(small_job_steps(3))));
    CHECK(verify_log(read_file(f.paths.sealed_log)) > 0);
    CHECK(open_live_log(f.paths.sealed_log, f.paths.live_log)->complete);
    CHECK(f.curve() == std::vector<std::uint32_t>{6, 9, 12, 15});
}

TEST_CASE("Job: nothing but the logs is left of a finished model") {
    Fixture f;
    f.run(small_job_steps(3));
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(f.paths.folder))
        names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    CHECK(names == std::vector<std::string>{"lease", "log.live", "log.live.idx", "model.arl"});
}

TEST_CASE("Job: a bad capture fails with its sentence, a failing machine asks for a retry, a full disk for patience") {
    CHECK(Fixture().failure(InputError("cameras.json: missing")) ==
          JobFailed{"cameras.json: missing", FailureCause::capture});
    CHECK(Fixture().failure(IoError("cable")) == JobFailed{"cable", FailureCause::machine});
    CHECK(Fixture().failure(DiskFull("disk")) == JobFailed{"disk", FailureCause::no_room});
    CHECK(Fixture().failure(std::bad_alloc()).cause == FailureCause::capture);
}

TEST_CASE("Job: one that is stopped leaves no sealed log, and goes on later") {
    Fixture f;
    JobSteps steps = small_job_steps(5);
    steps.reconstruct = [](const Capture&, const ReconstructOptions&, ModelSink& sink, const ProgressFn&,
                           std::stop_token, RefinementJournal& journal) {
        journal.begin({});
        write_octahedron(sink);
        journal.batch({});
        return ReconstructResult{.curve = {}, .iterations = {}, .stopped = true};
    };
    CHECK(std::holds_alternative<JobStopped>(f.run(steps)));
    CHECK_FALSE(std::filesystem::exists(f.paths.sealed_log));
    ++f.job.epoch;
    CHECK(std::holds_alternative<JobDone>(f.run(steps)));
    CHECK(read_file(f.paths.sealed_log) == undisturbed().first);
}

TEST_CASE("Job: a log that an earlier attempt sealed is the model") {
    Fixture f;
    f.run(small_job_steps(3));
    const auto sealed = read_file(f.paths.sealed_log);
    ++f.job.epoch;
    CHECK(std::holds_alternative<JobDone>(f.run(small_job_steps(1))));
    CHECK(read_file(f.paths.sealed_log) == sealed);
}

TEST_CASE("Job: killed at any batch it goes on behind its last one, and ends as if it never had been") {
    for (const int n_vertices : {6, 9, 15, 21}) {
        Fixture f;
        f.run_until(killed_at(n_vertices));
        const auto left = read_file(f.paths.live_log);
        CHECK(is_front_of(left, undisturbed().second));
        CHECK(std::holds_alternative<JobDone>(f.run(small_job_steps(5))));
        CHECK(f.last_begin() == left.size());
        CHECK(f.curve() == std::vector<std::uint32_t>{6, 9, 12, 15, 18, 21});  // no batch was made twice
        CHECK(read_file(f.paths.live_log) == undisturbed().second);
        CHECK(read_file(f.paths.sealed_log) == undisturbed().first);
    }
}

TEST_CASE("Job: killed again and again it still ends as if it never had been") {
    Fixture f;
    for (const int n_vertices : {6, 9, 12, 15, 18}) f.run_until(killed_at(n_vertices));
    f.run(small_job_steps(5));
    CHECK(read_file(f.paths.sealed_log) == undisturbed().first);
}

TEST_CASE("Job: frames that are durable but were not yet marked are compared, not written twice") {
    Fixture f;
    f.run_until(killed_at(12));
    const auto mark = read_file(f.paths.folder / "log.live.mark");
    f.run_until(killed_at(18));
    replace_file(f.paths.folder / "log.live.mark", mark);
    const auto view = f.store.open_live_log(f.job.model_id).value();
    f.run(small_job_steps(5));
    CHECK(read_file(f.paths.sealed_log) == undisturbed().first);
    CHECK(read_file(f.paths.live_log) == undisturbed().second);
    // Who opened the log before has a file that only grew.
    CHECK(file_size(*view.file) == undisturbed().second.size());
}

TEST_CASE("Job: a frame that was cut by the worker's death is written again") {
    Fixture f;
    f.run_until(killed_at(15));
    auto bytes = read_file(f.paths.live_log);
    const auto begun = std::span(undisturbed().second).subspan(bytes.size(), 11);
    bytes.insert(bytes.end(), begun.begin(), begun.end());
    replace_file(f.paths.live_log, bytes);
    f.run(small_job_steps(5));
    CHECK(read_file(f.paths.live_log) == undisturbed().second);
}

TEST_CASE("Job: what cannot be gone on with is begun anew under another id") {
    for (const bool is_damaged : {true, false}) {
        Fixture f;
        f.run_until(killed_at(15));
        const LogView before = f.store.open_log(f.job.model_id).value();
        JobSteps steps = small_job_steps(5);
        if (is_damaged) {
            auto bytes = read_file(f.paths.live_log);
            bytes[bytes.size() / 2] ^= std::byte{1};
            replace_file(f.paths.live_log, bytes);
        } else {  // another program, whose colours are others, is behind the last mark
            const auto mark = read_file(f.paths.folder / "log.live.mark");
            f.run_until(killed_at(18));
            replace_file(f.paths.folder / "log.live.mark", mark);
            steps.resume = [](const Capture&, const ReconstructOptions&, const RefinementStart&,
                              std::optional<RefinementPoint> point, ModelSink& sink, const ProgressFn&, std::stop_token,
                              RefinementJournal&) {
                const SplitRecord record = point->state.split(3, [](const ScalarSite&) { return 1; });
                sink.batch({{record}}, point->state, std::vector<Rgb8>(3), {});
                sink.finish();
                return ReconstructResult{};
            };
        }
        CHECK(std::holds_alternative<JobDone>(f.run(steps)));
        const LogView after = f.store.open_log(f.job.model_id).value();
        CHECK(after.log_id != before.log_id);
        CHECK(after.rows.back().n_vertices == 21);
        CHECK(verify_log(read_file(f.paths.sealed_log)) > 0);
        CHECK(f.last_begin() == 0);
    }
}

TEST_CASE("Job: a damaged checkpoint costs time, but no frame") {
    Fixture f;
    f.run_until(killed_at(15));
    replace_file(f.paths.folder / "log.live.checkpoint", as_bytes("what"));
    CHECK(std::holds_alternative<JobDone>(f.run(small_job_steps(5))));
    CHECK(read_file(f.paths.sealed_log) == undisturbed().first);
}

TEST_CASE("Job: a worker whose lease was given to another changes nothing any more, and says no word of failure") {
    Fixture f;
    DirectoryLogStore other(f.folder.path());
    std::vector<std::byte> left;
    const WorkerMessage end = f.run(small_job_steps(5, [&](int n) {
        if (n != 12) return;
        other.take(f.job.model_id, f.job.epoch + 1);
        left = read_file(f.paths.live_log);
    }));
    CHECK(std::holds_alternative<JobStopped>(end));
    CHECK(read_file(f.paths.live_log) == left);
    CHECK_FALSE(std::filesystem::exists(f.paths.sealed_log));
}

TEST_CASE("Durable sink: an index that readers have is not replaced by one with fewer rows") {
    Fixture f;
    f.run_until(killed_at(18));
    const std::size_t n_rows = f.store.open_live_log(f.job.model_id)->rows.size();
    auto sink = DurableSink(f.store.take(f.job.model_id, 9), log_id_of(f.job.model_id, 1), [](const RatePoint&) {}, {});
    RefinableMesh mesh = write_octahedron(sink);
    CHECK(f.store.open_live_log(f.job.model_id)->rows.size() == n_rows);
    refine_small_model(mesh, sink, 5);
    CHECK(f.store.open_live_log(f.job.model_id)->rows.size() > n_rows);
}

TEST_CASE("Worker message: each kind survives its line") {
    const std::vector<WorkerMessage> messages = {
        JobBegun{1u << 30},
        JobProgress{.stage = "refine", .fraction = 0.25, .n_vertices = 7, .n_bytes = 1u << 30, .psi = 3.5},
        JobProgress{.stage = "load", .seconds_left = 12.5},
        RatePoint{.n_vertices = 7, .n_bytes = 9, .psi = 1.5, .seconds = 2},
        JobFailed{"a \"quoted\"\nsentence", FailureCause::machine},
        JobFailed{"full", FailureCause::no_room},
        JobDone{},
        JobStopped{}};
    for (const WorkerMessage& message : messages) {
        const std::string line = encode_worker_message(message);
        CHECK(line.find('\n') == line.size() - 1);
        CHECK(decode_worker_message(line) == message);
    }
}

TEST_CASE("Worker message: what is none is refused") {
    for (const char* line : {"", "{}", "[]", "{\"type\":\"party\"}", "{\"type\":\"rate\",\"vertices\":\"x\"}", "noise",
                             "{\"type\":\"failed\",\"error\":\"\",\"cause\":\"weather\"}"})
        CHECK_THROWS_AS(decode_worker_message(line), DecodeError);
}
