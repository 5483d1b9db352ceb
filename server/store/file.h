#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace anyrate {

/// Owns a file descriptor; -1 is none.
class FileHandle {
public:
    FileHandle() = default;
    explicit FileHandle(int descriptor) : descriptor_(descriptor) {}
    FileHandle(FileHandle&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    FileHandle& operator=(FileHandle&& other) noexcept;
    ~FileHandle();

    int get() const { return descriptor_; }
    explicit operator bool() const { return descriptor_ >= 0; }

private:
    int descriptor_ = -1;
};

/// Opens an existing file for reading; an empty handle if there is none. @throws IoError for every other failure
FileHandle open_if_exists(const std::filesystem::path& file);

/// Makes `file`, or empties it. @throws IoError
FileHandle create_file(const std::filesystem::path& file);

/// Bytes in an open file. @throws IoError
std::uint64_t file_size(const FileHandle& file);

/// Up to `n` bytes from `offset`; fewer only where the file ends. @throws IoError
std::vector<std::byte> read_at(const FileHandle& file, std::uint64_t offset, std::size_t n);

/// A whole file. @throws IoError also if it is missing
std::vector<std::byte> read_file(const std::filesystem::path& file);

/// All of `bytes` at the current position. @throws IoError
void write_all(const FileHandle& file, std::span<const std::byte> bytes);

/// All of `bytes` at an offset. @throws IoError
void write_at(const FileHandle& file, std::uint64_t offset, std::span<const std::byte> bytes);

/// Removes a file; one that is not there is no error. @throws IoError
void remove_file(const std::filesystem::path& file);

/// Waits until the file's bytes are on the disk. @throws IoError
void sync_file(const FileHandle& file);

/// Waits until the names inside a folder (files made, renamed, removed) are on the disk. @throws IoError
void sync_folder(const std::filesystem::path& folder);

/// Replaces `file` by `bytes`, so that a reader sees the old or the new bytes whole and a crash leaves one of the two.
/// @throws IoError
void replace_file(const std::filesystem::path& file, std::span<const std::byte> bytes);

std::string_view as_text(std::span<const std::byte> bytes);
std::span<const std::byte> as_bytes(std::string_view text);

}  // namespace anyrate
