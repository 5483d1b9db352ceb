#include "server/http/wake_up.h"

#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>

namespace anyrate {

struct WakeUp::State {
    explicit State(const asio::any_io_executor& executor) : timer(executor) {}
    asio::steady_timer timer;
    bool raised = false;
};

std::shared_ptr<WakeUp> WakeUp::make(const asio::any_io_executor& executor) {
    return std::shared_ptr<WakeUp>(new WakeUp(std::make_shared<State>(executor)));
}

void WakeUp::raise() {
    // The posted work holds the state, for the waiter may be gone before it runs.
    asio::post(state_->timer.get_executor(), [state = state_] {
        state->raised = true;
        state->timer.cancel();
    });
}

awaitable<bool> WakeUp::wait(std::chrono::steady_clock::duration patience) {
    const std::shared_ptr<State> state = state_;
    if (!state->raised) {
        state->timer.expires_after(patience);
        ErrorCode ignored;  // cancelled is how a raise looks
        co_await state->timer.async_wait(asio::redirect_error(use_awaitable, ignored));
    }
    co_return std::exchange(state->raised, false);
}

}  // namespace anyrate
