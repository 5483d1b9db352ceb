#include "server/jobs/housekeeping.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "server/store/model_id.h"
#include "server/store/model_store.h"

namespace anyrate {
namespace {

namespace fs = std::filesystem;

constexpr auto leftover_age = std::chrono::hours(1);

/// Bytes of the files below; what vanishes meanwhile counts nothing.
std::uint64_t bytes_below(const fs::path& folder) {
    std::uint64_t n_bytes = 0;
    std::error_code error;
    for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
        std::error_code gone;
        const auto size = entry->is_regular_file(gone) ? entry->file_size(gone) : 0;
        if (!gone) n_bytes += size;
    }
    return n_bytes;
}

std::vector<fs::path> entries(const fs::path& folder) {
    std::error_code error;
    std::vector<fs::path> found{fs::directory_iterator(folder, error), fs::directory_iterator()};
    if (error) throw IoError("cannot read the folder " + folder.string() + ": " + error.message());
    std::ranges::sort(found);
    return found;
}

bool is_old(const fs::path& path) {
    std::error_code error;
    const auto changed = fs::last_write_time(path, error);
    return !error && fs::file_time_type::clock::now() - changed > leftover_age;
}

void remove_tree(const fs::path& path) {
    std::error_code error;
    fs::remove_all(path, error);
    if (error) throw IoError("cannot remove " + path.string() + ": " + error.message());
}

}  // namespace

Clearing find_clearing(Catalog& catalog, const fs::path& data, const KeepRule& rule, Timestamp now) {
    Clearing clearing;
    for (const fs::path& folder : entries(data / "models"))
        if (!catalog.find(folder.filename().string()) && is_old(folder)) clearing.leftovers.push_back(folder);
    for (const fs::path& file : entries(data / "uploads"))
        if (is_old(file)) clearing.leftovers.push_back(file);
    for (const fs::path& leftover : clearing.leftovers)
        clearing.n_bytes += fs::is_directory(leftover) ? bytes_below(leftover) : fs::file_size(leftover);

    if (rule.is_off()) return clearing;
    std::uint64_t n_kept = rule.bytes ? bytes_below(data / "models") : 0;
    for (const ModelRecord& model : catalog.final_before(Timestamp::max())) {
        const bool is_too_old = rule.age && now - model.updated > *rule.age;
        const bool is_too_much = rule.bytes && n_kept > *rule.bytes;
        if (!is_too_old && !is_too_much) continue;
        const std::uint64_t n_bytes = bytes_below(model_paths(data, model.id).folder);
        n_kept -= std::min(n_kept, n_bytes);
        clearing.n_bytes += n_bytes;
        clearing.models.push_back(model.id);
    }
    return clearing;
}

void clear(Catalog& catalog, const Clearing& clearing, const fs::path& data,
           const std::function<void(const std::string& id)>& on_removed) {
    for (const std::string& id : clearing.models) {
        catalog.remove(id);
        on_removed(id);
        remove_tree(model_paths(data, id).folder);
    }
    for (const fs::path& leftover : clearing.leftovers) remove_tree(leftover);
}

Housekeeper::Housekeeper(Catalog& catalog, fs::path data, KeepRule rule, std::chrono::milliseconds interval,
                         std::function<void(const std::string& id)> on_removed,
                         std::function<void(const std::string&)> log, std::function<void()> each_round)
    : catalog_(catalog),
      data_(std::move(data)),
      rule_(rule),
      interval_(interval),
      on_removed_(std::move(on_removed)),
      log_(std::move(log)),
      each_round_(std::move(each_round)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

Housekeeper::~Housekeeper() = default;

void Housekeeper::run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
        try {
            const auto now = std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now());
            const Clearing clearing = find_clearing(catalog_, data_, rule_, now);
            clear(catalog_, clearing, data_, on_removed_);
            if (clearing.n_bytes > 0)
                log_("cleared " + std::to_string(clearing.models.size()) + " models and " +
                     std::to_string(clearing.leftovers.size()) + " leftovers, " + std::to_string(clearing.n_bytes) +
                     " bytes");
            each_round_();
        } catch (const IoError& error) {
            log_(std::string("clearing: ") + error.what());
        }
        std::unique_lock lock(mutex_);
        woken_.wait_for(lock, stop, interval_, [] { return false; });
    }
}

}  // namespace anyrate
