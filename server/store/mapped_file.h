#pragma once
#include <cstddef>
#include <filesystem>
#include <span>

namespace anyrate {

/// A file's bytes as memory, for files that nobody else changes: one that shrinks meanwhile ends the process.
class MappedFile {
public:
    explicit MappedFile(const std::filesystem::path& file);  ///< @throws IoError also if it is missing
    ~MappedFile();
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;

    std::span<const std::byte> bytes() const { return bytes_; }

private:
    std::span<const std::byte> bytes_;
};

}  // namespace anyrate
