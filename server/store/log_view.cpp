#include "server/store/log_view.h"

#include <utility>

#include "proto/log_reader.h"
#include "server/store/live_log_file.h"

namespace anyrate {
namespace {

/// Header and index stand in front, so a short read nearly always has them; a longer index takes another read.
LogLayout read_head(const FileHandle& file, std::uint64_t size) {
    for (std::uint64_t n = 8192;; n *= 4) {
        LogLayout layout = read_layout(read_at(file, 0, static_cast<std::size_t>(n)));
        if (n >= size || !layout.header.sealed || !layout.index.empty()) return layout;
    }
}

std::optional<LogView> open_sealed(const std::filesystem::path& sealed) {
    auto file = std::make_shared<FileHandle>(open_if_exists(sealed));
    if (!*file) return std::nullopt;
    const std::uint64_t size = file_size(*file);
    LogLayout layout = read_head(*file, size);
    return LogView{.file = std::move(file),
                   .log_id = layout.header.log_id,
                   .sealed = true,
                   .complete = true,
                   .size = size,
                   .frames_begin = layout.frames_begin,
                   .rows = std::move(layout.index)};
}

std::optional<LogView> open_live(const std::filesystem::path& live) {
    auto file = std::make_shared<FileHandle>(open_if_exists(live));
    const FileHandle index_file = open_if_exists(side_index_of(live));
    if (!*file || !index_file) return std::nullopt;
    SideIndex index = decode_index(read_at(index_file, 0, static_cast<std::size_t>(file_size(index_file))));
    const LogLayout layout = read_layout(read_at(*file, 0, header_size));
    // Another attempt may have begun between the two opens.
    if (index.rows.empty() || index.log_id != layout.header.log_id) return std::nullopt;
    return LogView{.file = std::move(file),
                   .log_id = index.log_id,
                   .sealed = false,
                   .complete = false,
                   .size = layout.frames_begin + index.rows.back().end,
                   .frames_begin = layout.frames_begin,
                   .rows = std::move(index.rows)};
}

}  // namespace

std::optional<LogView> open_log(const std::filesystem::path& sealed, const std::filesystem::path& live) {
    if (auto view = open_sealed(sealed)) return view;
    if (auto view = open_live(live)) return view;
    return open_sealed(sealed);  // it may have been sealed between the two looks
}

std::optional<LogView> open_live_log(const std::filesystem::path& sealed, const std::filesystem::path& live) {
    const bool is_sealed = std::filesystem::exists(sealed);  // first: then the live file is whole
    auto view = open_live(live);
    if (!view) return open_sealed(sealed);
    view->complete = is_sealed;
    if (is_sealed) view->size = file_size(*view->file);  // the end frame has no row
    return view;
}

}  // namespace anyrate
