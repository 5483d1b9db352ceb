#include "server/http/network_thread.h"

#include <sched.h>

#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <utility>

namespace anyrate {
namespace {

/// The calling thread stays on a processor; if it may not, it runs where it is put.
void stay_on(int processor) {
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(static_cast<std::size_t>(processor), &only);
    ::sched_setaffinity(0, sizeof only, &only);
}

}  // namespace

void NetworkThread::run(awaitable<void> connection) {
    ++n_connections_;
    asio::co_spawn(loop_, std::move(connection), [this](std::exception_ptr) { --n_connections_; });
}

void NetworkThread::start() {
    watch_deadlines();
    thread_ = std::jthread([this] {
        if (processor_) stay_on(*processor_);
        loop_.run();
    });
}

void NetworkThread::stop() {
    loop_.stop();
    if (thread_.joinable()) thread_.join();
}

void NetworkThread::watch_deadlines() {
    tick_.expires_after(Deadlines::interval);
    tick_.async_wait([this](ErrorCode error) {
        if (error) return;
        deadlines_.enforce(std::chrono::steady_clock::now());
        watch_deadlines();
    });
}

}  // namespace anyrate
