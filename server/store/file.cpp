#include "server/store/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

#include "core/error.h"

namespace anyrate {
namespace {

[[noreturn]] void fail(const std::string& what, int error) {
    const std::string sentence = what + ": " + std::strerror(error);
    if (error == ENOSPC || error == EDQUOT) throw DiskFull(sentence);
    throw IoError(sentence);
}

FileHandle open_for_reading(const std::filesystem::path& file) {
    return FileHandle(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
}

}  // namespace

FileHandle& FileHandle::operator=(FileHandle&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
}

FileHandle::~FileHandle() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

FileHandle open_if_exists(const std::filesystem::path& file) {
    FileHandle handle = open_for_reading(file);
    if (!handle && errno != ENOENT) fail("cannot open " + file.string(), errno);
    return handle;
}

FileHandle create_file(const std::filesystem::path& file) {
    FileHandle handle(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0640));
    if (!handle) fail("cannot create " + file.string(), errno);
    return handle;
}

std::uint64_t file_size(const FileHandle& file) {
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) fail("cannot read the size of a file", errno);
    return static_cast<std::uint64_t>(status.st_size);
}

std::vector<std::byte> read_at(const FileHandle& file, std::uint64_t offset, std::size_t n) {
    const std::uint64_t size = file_size(file);
    if (offset >= size) return {};
    std::vector<std::byte> bytes(static_cast<std::size_t>(std::min<std::uint64_t>(n, size - offset)));
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t got =
            ::pread(file.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail("cannot read a file", errno);
        if (got == 0) break;  // it was cut since fstat
        done += static_cast<std::size_t>(got);
    }
    bytes.resize(done);
    return bytes;
}

std::vector<std::byte> read_file(const std::filesystem::path& file) {
    const FileHandle handle = open_for_reading(file);
    if (!handle) fail("cannot open " + file.string(), errno);
    return read_at(handle, 0, static_cast<std::size_t>(file_size(handle)));
}

void write_all(const FileHandle& file, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t put = ::write(file.get(), bytes.data(), bytes.size());
        if (put < 0 && errno == EINTR) continue;
        if (put < 0) fail("cannot write a file", errno);
        bytes = bytes.subspan(static_cast<std::size_t>(put));
    }
}

void write_at(const FileHandle& file, std::uint64_t offset, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t put = ::pwrite(file.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (put < 0 && errno == EINTR) continue;
        if (put < 0) fail("cannot write a file", errno);
        bytes = bytes.subspan(static_cast<std::size_t>(put));
        offset += static_cast<std::uint64_t>(put);
    }
}

void remove_file(const std::filesystem::path& file) {
    if (::unlink(file.c_str()) != 0 && errno != ENOENT) fail("cannot remove " + file.string(), errno);
}

void sync_file(const FileHandle& file) {
    if (::fsync(file.get()) != 0) fail("cannot sync a file", errno);
}

void sync_folder(const std::filesystem::path& folder) {
    const FileHandle handle(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!handle) fail("cannot open folder " + folder.string(), errno);
    if (::fsync(handle.get()) != 0) fail("cannot sync folder " + folder.string(), errno);
}

void replace_file(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    std::filesystem::path part = file;
    part += ".part";
    {
        const FileHandle handle = create_file(part);
        write_all(handle, bytes);
        sync_file(handle);
    }
    if (::rename(part.c_str(), file.c_str()) != 0) fail("cannot rename " + part.string(), errno);
    sync_folder(file.has_parent_path() ? file.parent_path() : std::filesystem::path("."));
}

std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::span<const std::byte> as_bytes(std::string_view text) {
    return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

}  // namespace anyrate
