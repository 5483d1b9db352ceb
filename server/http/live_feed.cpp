#include "server/http/live_feed.h"

#include <boost/asio/post.hpp>
#include <exception>
#include <utility>

namespace anyrate {
namespace {

LiveView look_up(Service& service, const std::string& id, const std::shared_ptr<const LogBytes>& before) {
    // The model first: if it is final then, its log is whole.
    LiveView view{.model = service.catalog.find(id), .log = std::nullopt, .bytes = nullptr};
    if (view.model) view.log = service.store.open_live_log(id);
    if (view.log) view.bytes = LogBytes::read(*view.log, before);
    return view;
}

/// A feed that is told of news as long as it lives.
struct Subscribed {
    Subscribed(asio::thread_pool& pool, Service& service, ModelEvents& events, const std::string& id)
        : feed(std::make_shared<LiveFeed>(pool,
                                          [&service, id](const auto& before) { return look_up(service, id, before); })),
          subscription(events, id, [weak = std::weak_ptr(feed)] {
              if (const auto alive = weak.lock()) alive->look_again();
          }) {}

    std::shared_ptr<LiveFeed> feed;
    ModelEvents::Subscription subscription;
};

}  // namespace

LiveFeed::Client::Client(std::shared_ptr<LiveFeed> feed, std::shared_ptr<WakeUp> wake_up) : feed_(std::move(feed)) {
    bool is_first_look = false;
    {
        const std::lock_guard lock(feed_->mutex_);
        position_ = feed_->clients_.insert(feed_->clients_.end(), std::move(wake_up));
        is_first_look = !feed_->view_;
    }
    if (is_first_look) feed_->look_again();
}

LiveFeed::Client::~Client() {
    const std::lock_guard lock(feed_->mutex_);
    feed_->clients_.erase(position_);
}

std::shared_ptr<const LiveView> LiveFeed::Client::view() const {
    const std::lock_guard lock(feed_->mutex_);
    return feed_->view_;
}

void LiveFeed::look_again() {
    {
        const std::lock_guard lock(mutex_);
        has_news_ = true;
        if (std::exchange(is_looking_, true)) return;
    }
    asio::post(pool_, [weak = weak_from_this()] {
        if (const auto feed = weak.lock()) feed->look();
    });
}

void LiveFeed::look() {
    for (;;) {
        std::shared_ptr<const LiveView> before;
        {
            const std::lock_guard lock(mutex_);
            is_looking_ = std::exchange(has_news_, false);
            if (!is_looking_) return;
            before = view_;
        }
        auto view = std::make_shared<LiveView>();
        try {
            *view = look_up_(before ? before->bytes : nullptr);
        } catch (const std::exception&) {  // of the storage; the clients come again
            view->has_failed = true;
        }
        const std::lock_guard lock(mutex_);
        view_ = std::move(view);
        for (const auto& client : clients_) client->raise();
    }
}

std::shared_ptr<LiveFeed> LiveFeeds::of(const std::string& model_id) {
    const std::lock_guard lock(mutex_);
    std::erase_if(feeds_, [](const auto& feed) { return feed.second.expired(); });
    auto& known = feeds_[model_id];
    if (auto feed = known.lock()) return feed;
    const auto made = std::make_shared<Subscribed>(pool_, service_, events_, model_id);
    // The pointer to the feed keeps its subscription.
    std::shared_ptr<LiveFeed> feed(made, made->feed.get());
    known = feed;
    return feed;
}

}  // namespace anyrate
