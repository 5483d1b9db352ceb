#include "server/store/live_log_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "proto/log_writer.h"

namespace anyrate {
namespace {

FileHandle open_to_append(const std::filesystem::path& file) {
    FileHandle handle(::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0640));
    if (!handle) throw IoError("cannot open " + file.string() + ": " + std::strerror(errno));
    return handle;
}

std::filesystem::path with_suffix(std::filesystem::path file, const std::string& suffix) {
    file += suffix;
    return file;
}

}  // namespace

std::filesystem::path side_index_of(const std::filesystem::path& live) { return with_suffix(live, ".idx"); }

LiveLogFile::LiveLogFile(LogPaths paths, std::optional<LeaseFile> lease)
    : paths_(std::move(paths)), lease_(std::move(lease)) {
    guarded([&] {
        file_ = open_to_append(paths_.live);
        n_bytes_ = file_size(file_);
    });
}

LiveLogFile::~LiveLogFile() = default;

std::vector<std::byte> LiveLogFile::read() const { return read_at(file_, 0, static_cast<std::size_t>(n_bytes_)); }

std::optional<SideIndex> LiveLogFile::read_index() const {
    const FileHandle file = open_if_exists(side_index_of(paths_.live));
    if (!file) return std::nullopt;
    return decode_index(read_at(file, 0, static_cast<std::size_t>(file_size(file))));
}

void LiveLogFile::begin_anew() {
    guarded([&] {
        // Rows must go before their frames do.
        remove_file(side_index_of(paths_.live));
        remove_file(paths_.live);
        file_ = open_to_append(paths_.live);
        n_bytes_ = 0;
    });
}

void LiveLogFile::cut(std::uint64_t n_bytes) {
    guarded([&] { shorten(n_bytes); });
}

void LiveLogFile::append(std::span<const std::byte> frames) {
    guarded([&] {
        try {
            write_all(file_, frames);
            sync_file(file_);
        } catch (const IoError&) {
            // Part of a frame may be there. The file may be beyond help too; then the next writer cuts it.
            [[maybe_unused]] const int failed = ::ftruncate(file_.get(), static_cast<off_t>(n_bytes_));
            throw;
        }
        n_bytes_ += frames.size();
    });
}

void LiveLogFile::publish_index(std::uint64_t log_id, std::span<const IndexRow> rows) {
    guarded([&] { replace_file(side_index_of(paths_.live), encode_index(log_id, rows)); });
}

void LiveLogFile::seal(std::span<const IndexRow> rows) {
    const std::vector<std::byte> sealed =
        seal_log(read(), rows);  // takes its time, which a later lease need not wait for
    guarded([&] { replace_file(paths_.sealed, sealed); });
}

void LiveLogFile::keep_note(const std::string& name, std::span<const std::byte> bytes) {
    guarded([&] { replace_file(note_file(name), bytes); });
}

std::optional<std::vector<std::byte>> LiveLogFile::note(const std::string& name) const {
    const FileHandle file = open_if_exists(note_file(name));
    if (!file) return std::nullopt;
    return read_at(file, 0, static_cast<std::size_t>(file_size(file)));
}

void LiveLogFile::drop_note(const std::string& name) {
    guarded([&] { remove_file(note_file(name)); });
}

void LiveLogFile::guarded(const std::function<void()>& work) const {
    if (lease_)
        lease_->guarded(work);
    else
        work();
}

std::filesystem::path LiveLogFile::note_file(const std::string& name) const {
    return with_suffix(paths_.live, "." + name);
}

void LiveLogFile::shorten(std::uint64_t n_bytes) {
    if (::ftruncate(file_.get(), static_cast<off_t>(n_bytes)) != 0)
        throw IoError("cannot cut " + paths_.live.string() + ": " + std::strerror(errno));
    sync_file(file_);
    n_bytes_ = n_bytes;
}

}  // namespace anyrate
