#include "server/http/log_bytes.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "proto/header.h"

namespace anyrate {
namespace {

/// Pieces that are smaller are joined when the log has grown by more of them.
constexpr std::size_t least_piece = 64 * 1024;

std::vector<std::byte> read_exactly(const LogView& log, std::uint64_t begin, std::uint64_t end) {
    auto bytes = read_at(*log.file, begin, static_cast<std::size_t>(end - begin));
    if (bytes.size() != end - begin) throw IoError("a log is shorter than its index says");
    return bytes;
}

void make_header_live(std::vector<std::byte>& log) {
    Header header = decode_header(std::span(log).first(header_size));
    header.sealed = false;
    const auto live = encode_header(header);
    std::copy(live.begin(), live.end(), log.begin());
}

}  // namespace

std::shared_ptr<const LogBytes> LogBytes::read(const LogView& log, const std::shared_ptr<const LogBytes>& before) {
    const bool goes_on =
        before && before->log_id_ == log.log_id && before->sealed_ == log.sealed && before->size_ <= log.size;
    if (goes_on && before->size_ == log.size) return before;
    auto bytes = std::make_shared<LogBytes>();
    if (goes_on) bytes->pieces_ = before->pieces_;
    bytes->log_id_ = log.log_id;
    bytes->sealed_ = log.sealed;
    bytes->size_ = log.size;

    std::uint64_t begin = goes_on ? before->size_ : 0;
    std::vector<std::byte> piece;
    if (begin > 0 && bytes->pieces_.back().bytes->size() < least_piece) {
        piece = *bytes->pieces_.back().bytes;
        begin = bytes->pieces_.back().begin;
        bytes->pieces_.pop_back();
    }
    const auto news = read_exactly(log, begin + piece.size(), log.size);
    piece.insert(piece.end(), news.begin(), news.end());
    if (begin == 0 && log.sealed) make_header_live(piece);
    bytes->pieces_.push_back({begin, std::make_shared<const std::vector<std::byte>>(std::move(piece))});
    return bytes;
}

std::vector<std::span<const std::byte>> LogBytes::slice(std::uint64_t begin, std::uint64_t end) const {
    std::vector<std::span<const std::byte>> parts;
    auto piece = std::upper_bound(pieces_.begin(), pieces_.end(), begin,
                                  [](std::uint64_t at, const Piece& p) { return at < p.begin; });
    for (--piece; begin < end; ++piece) {
        const std::uint64_t piece_end = std::min(end, piece->begin + piece->bytes->size());
        parts.push_back(
            std::span(*piece->bytes)
                .subspan(static_cast<std::size_t>(begin - piece->begin), static_cast<std::size_t>(piece_end - begin)));
        begin = piece_end;
    }
    return parts;
}

}  // namespace anyrate
