#include <fcntl.h>
#include <sys/file.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <variant>

#include "core/error.h"
#include "server/cli/commands.h"
#include "server/cli/interrupt.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/worker_limits.h"

namespace anyrate {
namespace {

struct WorkerArguments {
    std::filesystem::path data;
    std::string model_id;
    ModelOptions options;
    int attempt = 1;
    std::uint64_t memory_mb = 0;
    int parent = 0;
};

/// Holds a model for this process. A worker of a server that was killed is being killed too; until it is gone the model
/// is waited for, so that two workers never write one log.
FileHandle lock_model(const ModelPaths& paths) {
    FileHandle lock(::open(paths.lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640));
    if (!lock) throw IoError("cannot open " + paths.lock.string());
    for (int n_tries = 0; ::flock(lock.get(), LOCK_EX | LOCK_NB) != 0; ++n_tries) {
        if (n_tries == 100) throw IoError("another worker holds model " + paths.folder.filename().string());
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return lock;
}

void report(const WorkerMessage& message) {
    const std::string line = encode_worker_message(message);
    // A server that does not listen any more has no use for the rest of the work.
    if (std::fwrite(line.data(), 1, line.size(), stdout) != line.size() || std::fflush(stdout) != 0)
        throw IoError("the server does not take the worker's reports");
}

int work(const WorkerArguments& arguments) {
    const Interrupt interrupt;
    apply_worker_limits({.memory_bytes = arguments.memory_mb << 20, .parent = arguments.parent});
    const ModelPaths paths = model_paths(arguments.data, arguments.model_id);
    const FileHandle lock = lock_model(paths);
    bool done = false;
    run_job(
        {.model_id = arguments.model_id, .paths = paths, .options = arguments.options, .attempt = arguments.attempt},
        real_job_steps(),
        [&](const WorkerMessage& message) {
            done = done || std::holds_alternative<JobDone>(message);
            report(message);
        },
        interrupt.token());
    return done ? 0 : 1;
}

}  // namespace

void add_worker(CLI::App& app, Command& command) {
    auto arguments = std::make_shared<WorkerArguments>();
    CLI::App* sub = app.add_subcommand("worker", "make one model of a data directory (serve starts this by itself)");
    sub->add_option("--data", arguments->data, "data directory")->required();
    sub->add_option("--model", arguments->model_id, "id of a model whose capture is there")->required();
    sub->add_option("--attempt", arguments->attempt, "number of the attempt; part of the log's identity")
        ->capture_default_str();
    sub->add_option("--vertices", arguments->options.n_vertices, "of the finest mesh")->capture_default_str();
    sub->add_option("--coarse", arguments->options.n_coarse, "of the coarse mesh")->capture_default_str();
    sub->add_option("--memory", arguments->memory_mb, "MB this process may use; 0 for no limit")->capture_default_str();
    sub->add_option("--parent", arguments->parent, "process without which this one ends");
    sub->callback([arguments, &command] { command = [arguments] { return work(*arguments); }; });
}

}  // namespace anyrate
