#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "server/jobs/scheduler.h"

namespace anyrate {

struct ServerOptions {
    std::string address = "127.0.0.1";
    std::uint16_t port = 8080;  ///< 0 takes a free one
    std::filesystem::path data = "anyrate-data";
    std::string token;  ///< of writers; without one the server listens on loopback only
    std::uint64_t max_upload_bytes = 1ull << 30;
    int n_network_threads = 2;
    std::filesystem::path viewer;  ///< folder of the web viewer's files; none there: a plain page
    SchedulerOptions jobs;
    WorkerCommand worker_command;
    LogLine log;
};

/// The whole server: stores, scheduler, listener.
class Server {
public:
    /// Opens the data directory and listens, and ignores SIGPIPE in this process; jobs that a dead server left behind
    /// are queued again.
    /// @throws InputError no address, or one beyond loopback without a token
    /// @throws IoError    the data directory or the port cannot be had
    explicit Server(ServerOptions options);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// "http://127.0.0.1:8080"
    std::string url() const;
    /// Serves until `stop` is requested, then drains: takes no new connection, tells the workers to stop, lets
    /// responses that are on their way end (20 s at most).
    void run(std::stop_token stop);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace anyrate
