#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "server/http/access_record.h"
#include "server/jobs/housekeeping.h"
#include "server/jobs/judge_upload.h"
#include "server/jobs/scheduler.h"

namespace anyrate {

struct ServerOptions {
    std::string address = "127.0.0.1";
    std::uint16_t port = 8080;  ///< 0 takes a free one
    std::filesystem::path data = "anyrate-data";
    std::string token = {};   ///< of writers, beside those of DATA/tokens.json; without any, loopback only
    bool is_private = false;  ///< reading needs a token, too
    std::filesystem::path tls_certificate = {}, tls_key = {};  ///< PEM files; empty for plain HTTP
    std::vector<std::string> cors_origins = {};                ///< whose pages may ask this server; "*" for any
    std::uint64_t max_upload_bytes = 1ull << 30;
    std::chrono::hours keep_captures = std::chrono::hours(24 * 7);  ///< that came file by file, since they were begun
    std::size_t max_connections = 10'000;
    int n_network_threads = 2;
    std::filesystem::path viewer = {};  ///< folder of the web viewer's files; none there: a plain page
    SchedulerOptions jobs = {};
    KeepRule keep = {};  ///< of finished models
    WorkerCommand worker_command;
    JudgeCommand judge_command = {};  ///< for zips that are uploaded; empty: they are left to the job
    LogLine log;
    std::function<void(const AccessRecord&)> log_access = {};  ///< takes requests; empty for none
    int log_from_status = 0;  ///< only those whose answer has such a status or a higher
};

/// The whole server: stores, scheduler, listener.
class Server {
public:
    /// Opens the data directory and listens, and ignores SIGPIPE in this process; jobs that a dead server left behind
    /// are queued again.
    /// @throws InputError no address, or one beyond loopback without a token; certificate or key are none
    /// @throws IoError    the data directory or the port cannot be had
    explicit Server(ServerOptions options);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// "http://127.0.0.1:8080", or https
    std::string url() const;
    /// Serves until `stop` is requested, then drains: takes no new connection, tells the workers to stop, lets
    /// responses that are on their way end (20 s at most).
    void run(std::stop_token stop);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace anyrate
