#pragma once
#include <filesystem>

#include "server/store/log_store.h"

namespace anyrate {

/// The logs of a data directory: DATA/models/<id>/log.live and model.arl, the lease in DATA/models/<id>/lease.
class DirectoryLogStore final : public LogStore {
public:
    explicit DirectoryLogStore(std::filesystem::path data);

    std::unique_ptr<LogAppender> take(const std::string& id, std::uint64_t epoch) override;
    std::optional<LogView> open_log(const std::string& id) const override;
    std::optional<LogView> open_live_log(const std::string& id) const override;

private:
    std::filesystem::path data_;
};

}  // namespace anyrate
