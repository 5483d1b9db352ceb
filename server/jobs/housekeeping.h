#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/store/catalog.h"

namespace anyrate {

/// How long models are kept that will not change any more; nothing is removed by default.
struct KeepRule {
    std::optional<std::chrono::milliseconds> age;  ///< since a model became final
    std::optional<std::uint64_t> bytes;            ///< of all models together; the oldest final ones go first
    bool is_off() const { return !age && !bytes; }
};

/// What a clearing would remove, or has removed.
struct Clearing {
    std::vector<std::string> models;               ///< ids that the catalog knew
    std::vector<std::filesystem::path> leftovers;  ///< folders of models that it does not know, unfinished files
    std::uint64_t n_bytes = 0;                     ///< of both
};

/// The models that go by a rule, and the leftovers of a crash: nothing is removed. What is younger than an hour is no
/// leftover: somebody may be about to enter it in the catalog.
/// @throws IoError
Clearing find_clearing(Catalog& catalog, const std::filesystem::path& data, const KeepRule& rule, Timestamp now);

/// Removes what find_clearing() found, the catalog's entry before the files: a crash in between leaves a leftover.
/// @param on_removed  told each model once it is gone from the catalog
/// @throws IoError
void clear(Catalog& catalog, const Clearing& clearing, const std::filesystem::path& data,
           const std::function<void(const std::string& id)>& on_removed);

/// Clears a data directory from time to time, on a thread of its own.
class Housekeeper {
public:
    /// Everything given must outlive it.
    /// @param log         takes one line for each clearing that removed something
    /// @param each_round  called after each; may throw IoError
    Housekeeper(
        Catalog& catalog, std::filesystem::path data, KeepRule rule, std::chrono::milliseconds interval,
        std::function<void(const std::string& id)> on_removed, std::function<void(const std::string&)> log,
        std::function<void()> each_round = [] {});
    ~Housekeeper();

private:
    void run(const std::stop_token& stop);

    Catalog& catalog_;
    std::filesystem::path data_;
    KeepRule rule_;
    std::chrono::milliseconds interval_;
    std::function<void(const std::string&)> on_removed_, log_;
    std::function<void()> each_round_;
    std::mutex mutex_;
    std::condition_variable_any woken_;
    std::jthread thread_;
};

}  // namespace anyrate
