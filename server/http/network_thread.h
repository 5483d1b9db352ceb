#pragma once
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <thread>

#include "server/http/net.h"
#include "server/http/stream.h"

namespace anyrate {

/// An event loop with a thread of its own. A connection lives on one of them from its first byte to its last, so what
/// belongs to it needs no lock.
class NetworkThread {
public:
    NetworkThread() = default;
    ~NetworkThread() { stop(); }
    NetworkThread(const NetworkThread&) = delete;
    NetworkThread& operator=(const NetworkThread&) = delete;

    asio::io_context& loop() { return loop_; }
    Deadlines& deadlines() { return deadlines_; }

    void start();
    void stop();  ///< returns when the thread has ended; what waits on the loop is dropped with this object

private:
    void watch_deadlines();

    Deadlines deadlines_;  // before the loop, which holds the connections
    asio::io_context loop_{1};
    asio::steady_timer tick_{loop_};
    std::jthread thread_;
};

}  // namespace anyrate
