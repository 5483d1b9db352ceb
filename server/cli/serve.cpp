#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/error.h"
#include "server/cli/commands.h"
#include "server/cli/interrupt.h"
#include "server/cli/listen_address.h"
#include "server/http/server.h"

namespace anyrate {
namespace {

struct ServeCommand {
    std::string listen = "127.0.0.1:8080";
    std::filesystem::path data = "anyrate-data";
    std::filesystem::path viewer = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "viewer";
    std::string token;
    int n_workers = 1;
    std::uint64_t worker_memory_mb = 4096;
    std::uint64_t max_upload_mb = 1024;
};

/// The worker is this very program, whatever its path has become since it started.
WorkerCommand worker_command(const ServeCommand& request) {
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string data = std::filesystem::absolute(request.data).string();
    const std::string parent = std::to_string(::getpid());
    const std::string memory = std::to_string(request.worker_memory_mb);
    return [=](const ModelRecord& model) -> std::vector<std::string> {
        return {program,      "worker",
                "--data",     data,
                "--model",    model.id,
                "--attempt",  std::to_string(model.attempts),
                "--vertices", std::to_string(model.options.n_vertices),
                "--coarse",   std::to_string(model.options.n_coarse),
                "--memory",   memory,
                "--parent",   parent};
    };
}

LogLine log_to_standard_error() {
    const auto mutex = std::make_shared<std::mutex>();
    return [mutex](const std::string& line) {
        const std::lock_guard lock(*mutex);
        std::fprintf(stderr, "%s\n", line.c_str());
    };
}

int serve(const ServeCommand& request) {
    const Interrupt interrupt;  // before any thread starts
    const ListenAddress listen = parse_listen_address(request.listen);
    Server server({.address = listen.address,
                   .port = listen.port,
                   .data = request.data,
                   .token = request.token,
                   .max_upload_bytes = request.max_upload_mb << 20,
                   .viewer = request.viewer,
                   .jobs = {.n_workers = request.n_workers},
                   .worker_command = worker_command(request),
                   .log = log_to_standard_error()});
    std::printf("listening on %s\n", server.url().c_str());
    std::fflush(stdout);
    server.run(interrupt.token());
    return 0;
}

}  // namespace

void add_serve(CLI::App& app, Command& command) {
    auto request = std::make_shared<ServeCommand>();
    CLI::App* sub = app.add_subcommand("serve", "take captures and serve models over HTTP");
    sub->set_config("--config", "", "read options from a file of lines like workers=2");
    sub->add_option("--listen", request->listen,
                    "address and port; port 0 takes a free one; beyond loopback needs a token")
        ->capture_default_str();
    sub->add_option("--data", request->data, "data directory; made if missing")->capture_default_str();
    sub->add_option("--workers", request->n_workers, "reconstructions at a time")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    sub->add_option("--worker-memory", request->worker_memory_mb, "MB a worker may use; 0 for no limit")
        ->capture_default_str();
    sub->add_option("--max-upload", request->max_upload_mb, "MB of one capture")
        ->check(CLI::Range(1, 1 << 20))
        ->capture_default_str();
    sub->add_option("--viewer", request->viewer, "folder of the web viewer; the one beside this program by default");
    sub->add_option("--token", request->token, "what writers must send; better given in the environment")
        ->envname("ANYRATE_TOKEN");
    sub->callback([request, &command] { command = [request] { return serve(*request); }; });
}

}  // namespace anyrate
