#include "server/jobs/job_runner.h"

#include <doctest/doctest.h>

#include <new>
#include <string>
#include <vector>

#include "core/error.h"
#include "proto/log_reader.h"
#include "tests/unit/server/small_model.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

struct Fixture {
    TemporaryFolder folder;
    Job job;
    std::vector<WorkerMessage> messages;

    Fixture() {
        job.model_id = std::string(26, 'a');
        job.paths = model_paths(folder.path(), job.model_id);
        std::filesystem::create_directories(job.paths.folder);
    }
    WorkerMessage run(const JobSteps& steps, std::stop_token stop = {}) {
        run_job(
            job, steps, [&](const WorkerMessage& message) { messages.push_back(message); }, stop);
        return messages.back();
    }
    template <class Error>
    JobFailed failure(const Error& error) {
        JobSteps steps = small_job_steps(1);
        steps.load = [&](const std::filesystem::path&) -> Capture { throw error; };
        return std::get<JobFailed>(run(steps));
    }
};

}  // namespace

TEST_CASE("Job: a model is sealed, sound, and its curve reported") {
    Fixture f;
    CHECK(std::holds_alternative<JobDone>(f.run(small_job_steps(3))));
    CHECK(verify_log(read_file(f.job.paths.sealed_log)) > 0);
    CHECK(open_live_log(f.job.paths.sealed_log, f.job.paths.live_log)->complete);
    std::vector<std::uint32_t> vertices;
    for (const WorkerMessage& message : f.messages)
        if (const auto* point = std::get_if<RatePoint>(&message)) vertices.push_back(point->n_vertices);
    CHECK(vertices == std::vector<std::uint32_t>{6, 9, 12, 15});
}

TEST_CASE("Job: a bad capture fails with its sentence, a failing machine asks for a retry") {
    CHECK(Fixture().failure(InputError("cameras.json: missing")) == JobFailed{"cameras.json: missing", false});
    CHECK(Fixture().failure(IoError("disk")) == JobFailed{"disk", true});
    CHECK_FALSE(Fixture().failure(std::bad_alloc()).retry);
}

TEST_CASE("Job: one that is stopped leaves no sealed log") {
    Fixture f;
    JobSteps steps = small_job_steps(1);
    steps.reconstruct = [](const Capture&, const ReconstructOptions&, ModelSink& sink, const ProgressFn&,
                           std::stop_token) {
        write_small_model(sink, 1);
        return ReconstructResult{.curve = {}, .iterations = {}, .stopped = true};
    };
    CHECK(std::holds_alternative<JobStopped>(f.run(steps)));
    CHECK_FALSE(std::filesystem::exists(f.job.paths.sealed_log));
}

TEST_CASE("Job: a log that an earlier attempt sealed is the model") {
    Fixture f;
    f.run(small_job_steps(3));
    const auto sealed = read_file(f.job.paths.sealed_log);
    f.job.attempt = 2;
    CHECK(std::holds_alternative<JobDone>(f.run(small_job_steps(1))));
    CHECK(read_file(f.job.paths.sealed_log) == sealed);
}

TEST_CASE("Job: a second attempt begins a log of its own") {
    Fixture f;
    JobSteps steps = small_job_steps(2);
    steps.reconstruct = [](const Capture&, const ReconstructOptions&, ModelSink& sink, const ProgressFn&,
                           std::stop_token) -> ReconstructResult {
        write_small_model(sink, 2);
        throw IoError("the disk is full");
    };
    f.run(steps);
    const LogView first = open_log(f.job.paths.sealed_log, f.job.paths.live_log).value();
    f.job.attempt = 2;
    f.run(small_job_steps(3));
    const LogView second = open_log(f.job.paths.sealed_log, f.job.paths.live_log).value();
    CHECK(first.log_id != second.log_id);
    CHECK(read_layout(read_at(*first.file, 0, first.size)).frames.size() == first.rows.size());
}

TEST_CASE("Worker message: each kind survives its line") {
    const std::vector<WorkerMessage> messages = {
        JobProgress{.stage = "refine", .fraction = 0.25, .n_vertices = 7, .n_bytes = 1u << 30, .psi = 3.5},
        JobProgress{.stage = "load"},
        RatePoint{.n_vertices = 7, .n_bytes = 9, .psi = 1.5, .seconds = 2},
        JobFailed{"a \"quoted\"\nsentence", true},
        JobDone{},
        JobStopped{}};
    for (const WorkerMessage& message : messages) {
        const std::string line = encode_worker_message(message);
        CHECK(line.find('\n') == line.size() - 1);
        CHECK(decode_worker_message(line) == message);
    }
}

TEST_CASE("Worker message: what is none is refused") {
    for (const char* line : {"", "{}", "[]", "{\"type\":\"party\"}", "{\"type\":\"rate\",\"vertices\":\"x\"}", "noise"})
        CHECK_THROWS_AS(decode_worker_message(line), DecodeError);
}
