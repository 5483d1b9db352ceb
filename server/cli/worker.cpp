#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>

#include "core/error.h"
#include "server/cli/commands.h"
#include "server/cli/interrupt.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/sandbox.h"
#include "server/jobs/worker_limits.h"
#include "server/store/directory_log_store.h"
#include "server/store/model_store.h"

namespace anyrate {
namespace {

struct WorkerArguments {
    std::filesystem::path data;
    std::string model_id;
    ModelOptions options;
    std::uint64_t epoch = 1;
    std::uint64_t memory_mb = 0;
    int parent = 0;
    bool no_sandbox = false;
};

constexpr std::uint64_t largest_file = std::uint64_t{5} << 30;  // a log ends at 4 GiB
constexpr int most_open_files = 256;

void report(const WorkerMessage& message) {
    const std::string line = encode_worker_message(message);
    // A server that does not listen any more has no use for the rest of the work.
    if (std::fwrite(line.data(), 1, line.size(), stdout) != line.size() || std::fflush(stdout) != 0)
        throw IoError("the server does not take the worker's reports");
}

/// What a reconstruction may reach: its model's folder, and of the system what libraries look up.
SandboxFolders folders_of(const ModelPaths& paths) {
    return {.readable = {"/usr/lib", "/lib", "/lib64", "/usr/share/locale", "/etc/ld.so.cache", "/dev/null",
                         "/dev/urandom", "/sys/devices/system/cpu", "/sys/devices/system/node", "/proc/self",
                         "/proc/cpuinfo", "/proc/meminfo"},
            .writable = {paths.folder}};
}

int work(const WorkerArguments& arguments) {
    const ModelPaths paths = model_paths(arguments.data, arguments.model_id);
    apply_worker_limits({.memory_bytes = arguments.memory_mb << 20,
                         .file_bytes = largest_file,
                         .open_files = most_open_files,
                         .parent = arguments.parent});
    if (!arguments.no_sandbox && enter_sandbox(folders_of(paths)) == 0)
        std::fprintf(stderr, "anyrate worker: this kernel has no Landlock; the worker can read what its user can\n");
    const Interrupt interrupt;
    DirectoryLogStore store(arguments.data);
    bool done = false;
    run_job(
        {.model_id = arguments.model_id,
         .capture = paths.capture,
         .options = arguments.options,
         .epoch = arguments.epoch},
        real_job_steps(), store,
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
    sub->add_option("--epoch", arguments->epoch, "of the lease on the model; a worker with an earlier one is refused")
        ->capture_default_str();
    sub->add_option("--vertices", arguments->options.n_vertices, "of the finest mesh")->capture_default_str();
    sub->add_option("--coarse", arguments->options.n_coarse, "of the coarse mesh")->capture_default_str();
    sub->add_option("--memory", arguments->memory_mb, "MB this process may use; 0 for no limit")->capture_default_str();
    sub->add_option("--parent", arguments->parent, "process without which this one ends");
    sub->add_flag("--no-sandbox", arguments->no_sandbox, "run without seccomp and Landlock (to debug it)");
    sub->callback([arguments, &command] { command = [arguments] { return work(*arguments); }; });
}

}  // namespace anyrate
