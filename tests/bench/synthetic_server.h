#pragma once
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "server/client/url.h"
#include "tests/bench/synthetic_log.h"

namespace anyrate::bench {

/// The stand-in for a worker: writes the log's frames one by one, and notes in DATA/stamps when each was durable. It
/// makes DATA/ready when it has begun, begins its frames when there is DATA/go, and ends, if clients are stalled, when
/// there is DATA/enough, or with the server that started it. @return the exit code
int run_synthetic_worker(const FanOutOptions& options);

/// Waits for a file that another process makes.
void wait_for_file(const std::filesystem::path& file);

/// A server in a process of its own, whose workers are run_synthetic_worker().
class ServerProcess {
public:
    explicit ServerProcess(const FanOutOptions& options);
    ~ServerProcess();
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;

    const Url& url() const { return url_; }
    std::uint16_t port() const { return static_cast<std::uint16_t>(std::stoi(url_.port)); }
    std::uint64_t resident_bytes() const;

private:
    pid_t pid_ = -1;
    Url url_;
};

}  // namespace anyrate::bench
