#pragma once
#include <filesystem>

#include "server/store/blob_store.h"

namespace anyrate {

/// Blobs as files: FOLDER/<model>/<file>.
class DirectoryBlobStore final : public BlobStore {
public:
    explicit DirectoryBlobStore(std::filesystem::path folder);

    void put(const std::string& name, std::span<const std::byte> bytes) override;
    void adopt(const std::string& name, const std::filesystem::path& file) override;
    std::optional<std::uint64_t> size(const std::string& name) const override;
    std::optional<std::vector<std::byte>> read(const std::string& name, std::uint64_t offset,
                                               std::size_t n) const override;
    void remove(const std::string& name) override;
    std::vector<std::string> list(const std::string& model) const override;

private:
    std::filesystem::path file_of(const std::string& name) const;
    void make_folder_of(const std::filesystem::path& file);

    std::filesystem::path folder_;
};

}  // namespace anyrate
