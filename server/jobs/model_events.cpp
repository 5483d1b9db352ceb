#include "server/jobs/model_events.h"

#include <utility>

namespace anyrate {

ModelEvents::Subscription::Subscription(ModelEvents& events, std::string id, Listener listener)
    : events_(events), id_(std::move(id)) {
    const std::lock_guard lock(events_.mutex_);
    auto& listeners = events_.listeners_[id_];
    position_ = listeners.insert(listeners.end(), std::move(listener));
}

ModelEvents::Subscription::~Subscription() {
    const std::lock_guard lock(events_.mutex_);
    const auto model = events_.listeners_.find(id_);
    model->second.erase(position_);
    if (model->second.empty()) events_.listeners_.erase(model);
}

void ModelEvents::notify(const std::string& id) {
    const std::lock_guard lock(mutex_);
    const auto model = listeners_.find(id);
    if (model == listeners_.end()) return;
    for (const Listener& listener : model->second) listener();
}

}  // namespace anyrate
