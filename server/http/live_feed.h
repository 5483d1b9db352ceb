#pragma once
#include <boost/asio/thread_pool.hpp>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "server/http/log_bytes.h"
#include "server/http/service.h"
#include "server/http/wake_up.h"
#include "server/jobs/model_events.h"

namespace anyrate {

/// What catalog and log of one model say at one moment. If the model is final, its log is whole.
struct LiveView {
    std::optional<ModelRecord> model;  ///< nullopt: there is no such model
    std::optional<LogView> log;
    std::shared_ptr<const LogBytes> bytes;  ///< of the log
    bool has_failed = false;                ///< the storage did not answer
};

/// What is shared by all live clients of one model: catalog and log are looked at once per news, not once per client,
/// and the bytes that are sent lie in memory once. Safe to call from several threads.
class LiveFeed : public std::enable_shared_from_this<LiveFeed> {
public:
    using LookUp = std::function<LiveView(const std::shared_ptr<const LogBytes>& before)>;

    LiveFeed(asio::thread_pool& pool, LookUp look_up) : pool_(pool), look_up_(std::move(look_up)) {}

    /// Keeps a client woken at every new view, as long as it lives.
    class Client {
    public:
        Client(std::shared_ptr<LiveFeed> feed, std::shared_ptr<WakeUp> wake_up);
        ~Client();
        Client(const Client&) = delete;
        Client& operator=(const Client&) = delete;

        std::shared_ptr<const LiveView> view() const;  ///< nullptr before the first look
        void look_again() { feed_->look_again(); }

    private:
        std::shared_ptr<LiveFeed> feed_;
        std::list<std::shared_ptr<WakeUp>>::iterator position_;
    };

    /// There may be news: looks on the pool, and once more if news come meanwhile.
    void look_again();

private:
    void look();

    asio::thread_pool& pool_;
    LookUp look_up_;
    std::mutex mutex_;
    std::shared_ptr<const LiveView> view_;
    std::list<std::shared_ptr<WakeUp>> clients_;
    bool is_looking_ = false, has_news_ = false;
};

/// The feeds of the models that have live clients.
class LiveFeeds {
public:
    /// All three outlive it, and the pool is joined before it goes.
    LiveFeeds(Service& service, ModelEvents& events, asio::thread_pool& pool)
        : service_(service), events_(events), pool_(pool) {}

    /// The feed of a model, which is kept as long as somebody holds it.
    std::shared_ptr<LiveFeed> of(const std::string& model_id);

private:
    Service& service_;
    ModelEvents& events_;
    asio::thread_pool& pool_;
    std::mutex mutex_;
    std::map<std::string, std::weak_ptr<LiveFeed>> feeds_;
};

}  // namespace anyrate
