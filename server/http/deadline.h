#pragma once
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <utility>

#include "server/http/net.h"

namespace anyrate {

/// Calls `on_expiry` on the executor if it still lives after `patience`; for waits that have no time limit of their
/// own. Made and destroyed on that executor, a strand.
class Deadline {
public:
    Deadline(const asio::any_io_executor& executor, std::chrono::steady_clock::duration patience,
             std::function<void()> on_expiry)
        : timer_(executor, patience) {
        timer_.async_wait([state = state_, on_expiry = std::move(on_expiry)](ErrorCode error) {
            if (error || !state->armed) return;
            state->expired = true;
            on_expiry();
        });
    }
    ~Deadline() { state_->armed = false; }
    Deadline(const Deadline&) = delete;
    Deadline& operator=(const Deadline&) = delete;

    bool has_expired() const { return state_->expired; }

private:
    struct State {
        bool armed = true, expired = false;
    };
    std::shared_ptr<State> state_ = std::make_shared<State>();
    asio::steady_timer timer_;
};

}  // namespace anyrate
