#pragma once
#include <chrono>
#include <memory>
#include <utility>

#include "server/http/net.h"

namespace anyrate {

/// Lets one coroutine wait until others raise it, from any thread. A raise is kept until the next wait.
class WakeUp {
public:
    /// @param executor  the waiting coroutine's, a strand
    static std::shared_ptr<WakeUp> make(const asio::any_io_executor& executor);

    void raise();
    /// @return true if it was raised, false if `patience` ran out
    awaitable<bool> wait(std::chrono::steady_clock::duration patience);

private:
    struct State;
    explicit WakeUp(std::shared_ptr<State> state) : state_(std::move(state)) {}
    std::shared_ptr<State> state_;
};

}  // namespace anyrate
