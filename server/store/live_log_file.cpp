#include "server/store/live_log_file.h"

#include <utility>
#include <vector>

#include "proto/log_writer.h"

namespace anyrate {

std::filesystem::path side_index_of(const std::filesystem::path& live) {
    std::filesystem::path index = live;
    index += ".idx";
    return index;
}

LiveLogFile::LiveLogFile(std::filesystem::path live) : path_(std::move(live)) { begin_anew(); }

LiveLogFile::~LiveLogFile() = default;

void LiveLogFile::begin_anew() {
    // Rows must go before their frames do.
    std::filesystem::remove(side_index_of(path_));
    std::filesystem::remove(path_);
    file_ = create_file(path_);
}

void LiveLogFile::append(std::span<const std::byte> frames) {
    write_all(file_, frames);
    sync_file(file_);
}

void LiveLogFile::publish_index(std::uint64_t log_id, std::span<const IndexRow> rows) {
    replace_file(side_index_of(path_), encode_index(log_id, rows));
}

void LiveLogFile::seal(const std::filesystem::path& sealed, std::span<const IndexRow> rows) {
    replace_file(sealed, seal_log(read_file(path_), rows));
}

}  // namespace anyrate
