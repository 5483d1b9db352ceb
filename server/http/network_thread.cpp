#include "server/http/network_thread.h"

namespace anyrate {

void NetworkThread::start() {
    watch_deadlines();
    thread_ = std::jthread([this] { loop_.run(); });
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
