#pragma once
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace anyrate {

/// Wakes whoever waits for news of a model: a new state, progress, or frames in its log. It carries no news itself; the
/// listener looks them up. Safe to call from several threads.
class ModelEvents {
public:
    using Listener = std::function<void()>;

    /// Keeps a listener in place as long as it lives; must not outlive the ModelEvents.
    class Subscription {
    public:
        Subscription(ModelEvents& events, std::string id, Listener listener);
        ~Subscription();
        Subscription(const Subscription&) = delete;
        Subscription& operator=(const Subscription&) = delete;

    private:
        ModelEvents& events_;
        std::string id_;
        std::list<Listener>::iterator position_;
    };

    /// Calls the listeners of a model on this thread, under a lock: a listener only posts, it does not work.
    void notify(const std::string& id);

private:
    std::mutex mutex_;
    std::map<std::string, std::list<Listener>> listeners_;
};

}  // namespace anyrate
