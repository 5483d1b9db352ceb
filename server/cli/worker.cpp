#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/error.h"
#include "server/cli/backend_choice.h"
#include "server/cli/commands.h"
#include "server/cli/interrupt.h"
#include "server/cli/one_of.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/judge_upload.h"
#include "server/jobs/sandbox.h"
#include "server/jobs/worker_limits.h"
#include "server/store/directory_log_store.h"
#include "server/store/model_store.h"

namespace anyrate {
namespace {

struct WorkerArguments {
    std::filesystem::path data;
    std::string model_id;
    std::filesystem::path judged_zip;  ///< empty: make the model
    ModelOptions options;
    std::uint64_t epoch = 1;
    std::uint64_t memory_mb = 0;
    int parent = 0;
    BackendKind backend = BackendKind::automatic;
    bool no_sandbox = false;
};

constexpr std::uint64_t largest_file = std::uint64_t{5} << 30;  // a log ends at 4 GiB
constexpr int most_open_files = 256;
constexpr std::chrono::seconds judging_time(20);  // of a processor; a gigabyte takes three

void send(const std::string& line) {
    // A server that does not listen any more has no use for the rest of the work.
    if (std::fwrite(line.data(), 1, line.size(), stdout) != line.size() || std::fflush(stdout) != 0)
        throw IoError("the server does not take the worker's reports");
}

/// What libraries look up of the system.
std::vector<std::filesystem::path> system_files() {
    return {"/usr/lib",
            "/lib",
            "/lib64",
            "/usr/share/locale",
            "/etc/ld.so.cache",
            "/dev/null",
            "/dev/urandom",
            "/sys/devices/system/cpu",
            "/sys/devices/system/node",
            "/proc/self",
            "/proc/cpuinfo",
            "/proc/meminfo"};
}

void confine(const WorkerArguments& arguments, const SandboxFolders& folders) {
    if (!arguments.no_sandbox && enter_sandbox(folders) == 0)
        std::fprintf(stderr, "anyrate worker: this kernel has no Landlock; the worker can read what its user can\n");
}

/// Looks through an upload that no job has been made of yet.
int judge(const WorkerArguments& arguments) {
    apply_worker_limits({.memory_bytes = arguments.memory_mb << 20,
                         .file_bytes = 1,
                         .open_files = most_open_files,
                         .processor_time = judging_time,
                         .parent = arguments.parent});
    SandboxFolders folders{.readable = system_files(), .writable = {}, .has_device = false};
    folders.readable.push_back(arguments.judged_zip);
    confine(arguments, folders);
    say_judgement(arguments.judged_zip,
                  [](const JudgementMessage& message) { send(encode_judgement_message(message)); });
    return 0;
}

void warn(const std::string& sentence) { std::fprintf(stderr, "anyrate worker: %s\n", sentence.c_str()); }

/// Before the sandbox closes: a driver opens devices and libraries and starts threads, which is refused inside. There a
/// GPU also needs calls (ioctl) that nobody else does, so a sandboxed worker takes one only if it is told to.
BackendChoice backend_of(const WorkerArguments& arguments) {
    if (arguments.backend == BackendKind::automatic && !arguments.no_sandbox)
        return choose_backend(BackendKind::cpu, warn);
    // Mesa would keep compiled shaders in files of the user.
    ::setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
    BackendChoice backend = choose_backend(arguments.backend, warn);
    warn(backend.sentence);
    return backend;
}

int work(const WorkerArguments& arguments) {
    if (!arguments.judged_zip.empty()) return judge(arguments);
    const ModelPaths paths = model_paths(arguments.data, arguments.model_id);
    apply_worker_limits({.memory_bytes = arguments.memory_mb << 20,
                         .file_bytes = largest_file,
                         .open_files = most_open_files,
                         .parent = arguments.parent});
    const BackendChoice backend = backend_of(arguments);
    confine(arguments, {.readable = system_files(), .writable = {paths.folder}, .has_device = backend.is_hardware});
    const Interrupt interrupt;
    DirectoryLogStore store(arguments.data);
    bool done = false;
    run_job(
        {.model_id = arguments.model_id,
         .capture = paths.capture,
         .thumbnails = paths.thumbnails,
         .options = arguments.options,
         .epoch = arguments.epoch},
        real_job_steps(backend.factory), store,
        [&](const WorkerMessage& message) {
            done = done || std::holds_alternative<JobDone>(message);
            send(encode_worker_message(message));
        },
        interrupt.token());
    return done ? 0 : 1;
}

}  // namespace

void add_worker(CLI::App& app, Command& command) {
    auto arguments = std::make_shared<WorkerArguments>();
    CLI::App* sub = app.add_subcommand("worker", "make one model of a data directory (serve starts this by itself)");
    sub->add_option("--data", arguments->data, "data directory")->required();
    CLI::Option* model = sub->add_option("--model", arguments->model_id, "id of a model whose capture is there");
    CLI::Option* judge = sub->add_option("--judge", arguments->judged_zip, "instead, look through a capture in a zip");
    model->excludes(judge);
    sub->add_option("--epoch", arguments->epoch, "of the lease on the model; a worker with an earlier one is refused")
        ->capture_default_str();
    sub->add_option("--vertices", arguments->options.n_vertices, "of the finest mesh")->capture_default_str();
    sub->add_option("--coarse", arguments->options.n_coarse, "of the coarse mesh")->capture_default_str();
    sub->add_option("--memory", arguments->memory_mb, "MB this process may use; 0 for no limit")->capture_default_str();
    sub->add_option("--parent", arguments->parent, "process without which this one ends");
    sub->add_option("--backend", arguments->backend,
                    "who computes photo-consistency: cpu; gpu; auto, in a sandbox the CPU, else a GPU if there is one")
        ->transform(one_of(numbers_of(backend_kinds())));
    sub->add_flag("--no-sandbox", arguments->no_sandbox, "run without seccomp and Landlock (to debug it)");
    sub->callback([arguments, &command] { command = [arguments] { return work(*arguments); }; });
}

}  // namespace anyrate
