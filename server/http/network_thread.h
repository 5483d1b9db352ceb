#pragma once
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <optional>
#include <thread>

#include "server/http/net.h"
#include "server/http/stream.h"

namespace anyrate {

/// An event loop with a thread of its own. A connection lives on one of them from its first byte to its last, so what
/// belongs to it needs no lock.
class NetworkThread {
public:
    /// @param processor  that the thread stays on; nullopt for any
    explicit NetworkThread(std::optional<int> processor) : processor_(processor) {}
    ~NetworkThread() { stop(); }
    NetworkThread(const NetworkThread&) = delete;
    NetworkThread& operator=(const NetworkThread&) = delete;

    asio::io_context& loop() { return loop_; }
    Deadlines& deadlines() { return deadlines_; }
    std::optional<int> processor() const { return processor_; }

    /// Runs a connection to its end; the thread counts it from now on.
    void run(awaitable<void> connection);
    std::size_t n_connections() const { return n_connections_; }

    void start();
    void stop();  ///< returns when the thread has ended; what waits on the loop is dropped with this object

private:
    void watch_deadlines();

    const std::optional<int> processor_;
    std::atomic<std::size_t> n_connections_ = 0;
    Deadlines deadlines_;  // before the loop, which holds the connections
    asio::io_context loop_{1};
    asio::steady_timer tick_{loop_};
    std::jthread thread_;
};

}  // namespace anyrate
