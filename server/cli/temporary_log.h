#pragma once
#include <filesystem>
#include <system_error>

namespace anyrate {

/// The growing log's place beside the model it becomes; nothing is left there when this ends.
class TemporaryLog {
public:
    explicit TemporaryLog(const std::filesystem::path& model) : path_(model.string() + ".part") {}
    ~TemporaryLog() {
        std::error_code ignored;  // another failure may be on its way, and nothing more can be done about this one
        std::filesystem::remove(path_, ignored);
        std::filesystem::remove(path_.string() + ".idx", ignored);
    }
    TemporaryLog(const TemporaryLog&) = delete;
    TemporaryLog& operator=(const TemporaryLog&) = delete;

    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

}  // namespace anyrate
