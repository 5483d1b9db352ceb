#pragma once
#include <chrono>
#include <condition_variable>
#include <functional>
#include <list>
#include <mutex>

namespace anyrate {

/// The connections that are open, so that a stopping server can ask them to end and wait until they have. Safe to call
/// from several threads.
class Sessions {
public:
    /// Counts a connection as long as it lives.
    class Membership {
    public:
        Membership(Sessions& sessions, std::function<void()> on_drain);
        ~Membership();
        Membership(const Membership&) = delete;
        Membership& operator=(const Membership&) = delete;

    private:
        Sessions& sessions_;
        std::list<std::function<void()>>::iterator position_;
    };

    std::size_t count() const;
    bool is_draining() const;
    /// Calls on_drain of every connection, and at once of each that comes later; it only posts.
    void drain();
    /// Waits until no connection is open. @return false if `patience` ran out
    bool wait_until_empty(std::chrono::milliseconds patience);

private:
    mutable std::mutex mutex_;
    std::condition_variable left_;
    bool draining_ = false;
    std::list<std::function<void()>> members_;
};

}  // namespace anyrate
