#include "server/http/sessions.h"

#include <utility>

namespace anyrate {

Sessions::Membership::Membership(Sessions& sessions, std::function<void()> on_drain) : sessions_(sessions) {
    const std::lock_guard lock(sessions_.mutex_);
    position_ = sessions_.members_.insert(sessions_.members_.end(), std::move(on_drain));
    if (sessions_.draining_) (*position_)();
}

Sessions::Membership::~Membership() {
    const std::lock_guard lock(sessions_.mutex_);
    sessions_.members_.erase(position_);
    sessions_.left_.notify_all();
}

std::size_t Sessions::count() const {
    const std::lock_guard lock(mutex_);
    return members_.size();
}

bool Sessions::is_draining() const {
    const std::lock_guard lock(mutex_);
    return draining_;
}

void Sessions::drain() {
    const std::lock_guard lock(mutex_);
    draining_ = true;
    for (const auto& on_drain : members_) on_drain();
}

bool Sessions::wait_until_empty(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return left_.wait_for(lock, patience, [&] { return members_.empty(); });
}

}  // namespace anyrate
