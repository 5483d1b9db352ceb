#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "server/cli/backend_choice.h"
#include "server/cli/commands.h"
#include "server/cli/config_file.h"
#include "server/cli/interrupt.h"
#include "server/cli/job_options.h"
#include "server/cli/listen_address.h"
#include "server/cli/one_of.h"
#include "server/cli/server_log.h"
#include "server/http/server.h"

namespace anyrate {
namespace {

struct ServeCommand {
    std::string listen = "127.0.0.1:8080";
    std::filesystem::path config;
    std::filesystem::path data = "anyrate-data";
    std::filesystem::path viewer = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "viewer";
    std::string token;
    bool is_private = false;
    std::filesystem::path tls_certificate, tls_key;
    std::vector<std::string> cors_origins;
    std::size_t max_connections = 10'000;
    int n_network_threads = 2;
    int keep_captures_days = 7;
    LogFormat log_format = LogFormat::plain;
    LogRequests log_requests = LogRequests::errors;
    JobOptions jobs;
    std::uint64_t max_upload_mb = 1024;
    std::string backend = "auto";
};

constexpr const char* judge_memory_mb = "2048";  // one file of a zip at a time is in memory, 1 GB at most

/// The worker is this very program, whatever its path has become since it started.
WorkerCommand worker_command(const ServeCommand& request) {
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string data = std::filesystem::absolute(request.data).string();
    const std::string parent = std::to_string(::getpid());
    const std::string memory = std::to_string(request.jobs.worker_memory_mb);
    const std::string backend = request.backend;
    return [=](const ModelRecord& model) -> std::vector<std::string> {
        return {program,      "worker",
                "--data",     data,
                "--model",    model.id,
                "--epoch",    std::to_string(model.epoch),
                "--vertices", std::to_string(model.options.n_vertices),
                "--coarse",   std::to_string(model.options.n_coarse),
                "--memory",   memory,
                "--backend",  backend,
                "--parent",   parent};
    };
}

JudgeCommand judge_command(const ServeCommand& request) {
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string data = std::filesystem::absolute(request.data).string();
    const std::string parent = std::to_string(::getpid());
    return [=](const std::filesystem::path& zip) -> std::vector<std::string> {
        return {program,    "worker",        "--data",   data,  "--judge", std::filesystem::absolute(zip).string(),
                "--memory", judge_memory_mb, "--parent", parent};
    };
}

int serve(const ServeCommand& request) {
    const Interrupt interrupt;  // before any thread starts
    const ListenAddress listen = parse_listen_address(request.listen);
    const SchedulerOptions jobs = request.jobs.scheduler();
    const ServerLog log = make_server_log(request.log_format, request.log_requests);
    Server server({.address = listen.address,
                   .port = listen.port,
                   .data = request.data,
                   .token = request.token,
                   .is_private = request.is_private,
                   .tls_certificate = request.tls_certificate,
                   .tls_key = request.tls_key,
                   .cors_origins = request.cors_origins,
                   .max_upload_bytes = request.max_upload_mb << 20,
                   .keep_captures = std::chrono::hours(24 * request.keep_captures_days),
                   .max_connections = request.max_connections,
                   .n_network_threads = request.n_network_threads,
                   .viewer = request.viewer,
                   .jobs = jobs,
                   .keep = keep_rule(request.jobs.keep_days, request.jobs.keep_mb),
                   .worker_command = worker_command(request),
                   .judge_command = judge_command(request),
                   .log = log.line,
                   .log_access = log.request,
                   .log_from_status = log.from_status});
    std::printf("listening on %s\n", server.url().c_str());
    std::fflush(stdout);
    server.run(interrupt.token());
    return 0;
}

void add_access_options(CLI::App& sub, ServeCommand& request) {
    sub.add_option("--token", request.token,
                   "what writers must send, beside the tokens made by `anyrate token`; better given in the environment")
        ->envname("ANYRATE_TOKEN");
    sub.add_flag("--private", request.is_private, "reading needs a token, too")->envname("ANYRATE_PRIVATE");
    sub.add_option("--tls-certificate", request.tls_certificate,
                   "certificate chain (PEM); with it the server speaks HTTPS")
        ->envname("ANYRATE_TLS_CERTIFICATE");
    sub.add_option("--tls-key", request.tls_key, "the certificate's private key (PEM)")->envname("ANYRATE_TLS_KEY");
    sub.add_option("--cors-origin", request.cors_origins,
                   "origins whose pages may use this server, as in https://example.org; * for any; may be repeated")
        ->envname("ANYRATE_CORS_ORIGIN");
}

void add_operation_options(CLI::App& sub, ServeCommand& request) {
    sub.add_option("--max-connections", request.max_connections, "connections at a time; further ones wait")
        ->envname("ANYRATE_MAX_CONNECTIONS")
        ->check(CLI::Range(1, 1'000'000))
        ->capture_default_str();
    sub.add_option("--network-threads", request.n_network_threads,
                   "threads that serve connections; as many as there are processors: each stays on one")
        ->envname("ANYRATE_NETWORK_THREADS")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    sub.add_option("--keep-captures", request.keep_captures_days,
                   "days until a capture that came file by file is removed")
        ->envname("ANYRATE_KEEP_CAPTURES")
        ->check(CLI::Range(1, 36'500))
        ->capture_default_str();
    const std::map<std::string, LogFormat> formats = {{"plain", LogFormat::plain}, {"json", LogFormat::json}};
    sub.add_option("--log-format", request.log_format, "of the lines on standard error: plain or json")
        ->envname("ANYRATE_LOG_FORMAT")
        ->transform(one_of(numbers_of(formats)))
        ->default_str("plain");
    const std::map<std::string, LogRequests> requests = {
        {"none", LogRequests::none}, {"errors", LogRequests::errors}, {"all", LogRequests::all}};
    sub.add_option("--log-requests", request.log_requests,
                   "which requests are logged: none, errors (from 400 on) or all")
        ->envname("ANYRATE_LOG_REQUESTS")
        ->transform(one_of(numbers_of(requests)))
        ->default_str("errors");
}

}  // namespace

void add_serve(CLI::App& app, Command& command) {
    auto request = std::make_shared<ServeCommand>();
    CLI::App* sub = app.add_subcommand("serve", "take captures and serve models over HTTP");
    sub->add_option("--config", request->config,
                    "read options from a file of lines like workers=2; flags and environment go first")
        ->envname("ANYRATE_CONFIG")
        ->configurable(false);
    sub->add_option("--listen", request->listen,
                    "address and port; port 0 takes a free one; beyond loopback needs a token")
        ->envname("ANYRATE_LISTEN")
        ->capture_default_str();
    sub->add_option("--data", request->data, "data directory; made if missing")
        ->envname("ANYRATE_DATA")
        ->capture_default_str();
    add_job_options(*sub, request->jobs);
    sub->add_option("--backend", request->backend,
                    "who computes photo-consistency: cpu; gpu; auto, for sandboxed workers the CPU")
        ->envname("ANYRATE_BACKEND")
        ->check(CLI::IsMember(backend_kinds()))
        ->capture_default_str();
    sub->add_option("--max-upload", request->max_upload_mb, "MB of one capture")
        ->envname("ANYRATE_MAX_UPLOAD")
        ->check(CLI::Range(1, 1 << 20))
        ->capture_default_str();
    sub->add_option("--viewer", request->viewer, "folder of the web viewer; the one beside this program by default")
        ->envname("ANYRATE_VIEWER");
    add_access_options(*sub, *request);
    add_operation_options(*sub, *request);
    sub->footer(
        "The configuration file has the same names as the flags, without dashes: workers=2. SIGTERM ends the server\n"
        "when the answers that are under way have been sent, 30 s at most.");
    sub->callback([request, &command, sub] {
        if (!request->config.empty()) read_config_file(*sub, request->config);
        command = [request] { return serve(*request); };
    });
}

}  // namespace anyrate
