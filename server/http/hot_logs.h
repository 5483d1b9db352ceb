#pragma once
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "server/store/log_view.h"

namespace anyrate {

/// A sealed log with its bytes.
struct HotLog {
    LogView view;
    std::string etag;                                     ///< of the whole log
    std::shared_ptr<const std::vector<std::byte>> bytes;  ///< nullptr if it is too long to be kept in memory
};

/// The sealed logs that were asked for last: they never change, so neither catalog nor disk is asked for them again.
/// The one that was not asked for the longest goes first. Safe to call from several threads.
class HotLogs {
public:
    /// @param max_bytes  of all logs in memory; a longer one than a quarter of it is kept open, not read
    explicit HotLogs(std::uint64_t max_bytes = 64u << 20) : max_bytes_(max_bytes) {}

    std::shared_ptr<const HotLog> find(std::string_view id);
    /// Reads a log, unless it is too long, and keeps it.
    /// @param generation  as it was before the catalog was asked for the model: a model that was removed since is not
    ///                    kept
    /// @throws IoError
    std::shared_ptr<const HotLog> keep(const std::string& id, LogView sealed, std::string etag,
                                       std::uint64_t generation);
    std::uint64_t generation() const;
    /// The model is removed.
    void forget(const std::string& id);

    /// Of all that are kept.
    std::vector<std::string> ids() const;

private:
    static constexpr std::size_t max_logs = 256;  // each holds a file open
    struct Entry {
        std::string id;
        std::shared_ptr<const HotLog> log;
    };
    void drop(std::list<Entry>::iterator entry);

    const std::uint64_t max_bytes_;
    mutable std::mutex mutex_;
    std::uint64_t generation_ = 0, n_bytes_ = 0;
    std::list<Entry> entries_;  ///< the one that was asked for last is first
    std::unordered_map<std::string_view, std::list<Entry>::iterator> by_id_;
};

}  // namespace anyrate
