#include "server/http/hot_logs.h"

#include <utility>

#include "core/error.h"

namespace anyrate {
namespace {

std::uint64_t bytes_of(const HotLog& log) { return log.bytes ? log.bytes->size() : 0; }

std::shared_ptr<const std::vector<std::byte>> read_log(const LogView& view) {
    auto bytes = std::make_shared<std::vector<std::byte>>(read_at(*view.file, 0, static_cast<std::size_t>(view.size)));
    if (bytes->size() != view.size) throw IoError("a sealed log is shorter than it was");
    return bytes;
}

}  // namespace

std::shared_ptr<const HotLog> HotLogs::find(std::string_view id) {
    const std::lock_guard lock(mutex_);
    const auto found = by_id_.find(id);
    if (found == by_id_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found->second);
    return found->second->log;
}

std::shared_ptr<const HotLog> HotLogs::keep(const std::string& id, LogView sealed, std::string etag,
                                            std::uint64_t generation) {
    auto log = std::make_shared<HotLog>(HotLog{std::move(sealed), std::move(etag), nullptr});
    if (log->view.size <= max_bytes_ / 4) log->bytes = read_log(log->view);
    const std::lock_guard lock(mutex_);
    if (generation != generation_ || by_id_.contains(id)) return log;
    entries_.push_front({id, log});
    by_id_.emplace(entries_.front().id, entries_.begin());
    n_bytes_ += bytes_of(*log);
    while (entries_.size() > 1 && (entries_.size() > max_logs || n_bytes_ > max_bytes_))
        drop(std::prev(entries_.end()));
    return log;
}

std::uint64_t HotLogs::generation() const {
    const std::lock_guard lock(mutex_);
    return generation_;
}

void HotLogs::forget(const std::string& id) {
    const std::lock_guard lock(mutex_);
    ++generation_;
    if (const auto found = by_id_.find(id); found != by_id_.end()) drop(found->second);
}

std::vector<std::string> HotLogs::ids() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> ids;
    for (const Entry& entry : entries_) ids.push_back(entry.id);
    return ids;
}

void HotLogs::drop(std::list<Entry>::iterator entry) {
    n_bytes_ -= bytes_of(*entry->log);
    by_id_.erase(entry->id);
    entries_.erase(entry);
}

}  // namespace anyrate
