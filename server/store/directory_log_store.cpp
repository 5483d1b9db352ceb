#include "server/store/directory_log_store.h"

#include <utility>

#include "server/store/live_log_file.h"
#include "server/store/model_store.h"

namespace anyrate {

DirectoryLogStore::DirectoryLogStore(std::filesystem::path data) : data_(std::move(data)) {}

std::unique_ptr<LogAppender> DirectoryLogStore::take(const std::string& id, std::uint64_t epoch) {
    const ModelPaths paths = model_paths(data_, id);
    return std::make_unique<LiveLogFile>(LogPaths{paths.live_log, paths.sealed_log}, LeaseFile(paths.lease, epoch));
}

std::optional<LogView> DirectoryLogStore::open_log(const std::string& id) const {
    const ModelPaths paths = model_paths(data_, id);
    return anyrate::open_log(paths.sealed_log, paths.live_log);
}

std::optional<LogView> DirectoryLogStore::open_live_log(const std::string& id) const {
    const ModelPaths paths = model_paths(data_, id);
    return anyrate::open_live_log(paths.sealed_log, paths.live_log);
}

}  // namespace anyrate
