#include <limits>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/log_reader.h"
#include "proto/log_writer.h"

namespace anyrate {

namespace {

/// Rows of the log's own frames, with the distortions of `known` where that has the same row.
std::vector<IndexRow> with_distortions(std::vector<IndexRow> rows, std::span<const IndexRow> known) {
    for (std::size_t i = 0; i < rows.size() && i < known.size(); ++i) {
        if (rows[i].n_vertices != known[i].n_vertices || rows[i].end != known[i].end) break;
        rows[i] = known[i];
    }
    return rows;
}

std::vector<std::byte> end_frame(const FrameInfo& last, std::uint32_t state_hash) {
    return encode_frame({.type = FrameType::end,
                         .sequence = last.sequence + 1,
                         .n_vertices_before = last.n_vertices_after,
                         .state_hash = state_hash},
                        {});
}

}  // namespace

std::vector<std::byte> seal_log(std::span<const std::byte> live, std::span<const IndexRow> rows) {
    const LogLayout layout = read_layout(live);
    if (layout.header.sealed) throw DecodeError("seal: the log is sealed already");
    if (layout.frames.empty()) throw DecodeError("seal: the log has no whole base");

    ByteWriter out;
    out.put(sealed_header(live));
    out.put(encode_frame({.type = FrameType::index, .sequence = index_sequence},
                         encode_index_rows(with_distortions(layout.index, rows))));
    out.put(live.subspan(layout.frames_begin, layout.whole_bytes - layout.frames_begin));
    if (!layout.ended) {
        std::uint32_t state_hash = 0;
        for (const FrameInfo& frame : layout.frames) {
            if (frame.type == FrameType::base || frame.type == FrameType::refine) state_hash = frame.state_hash;
        }
        out.put(end_frame(layout.frames.back(), state_hash));
    }
    return out.take();
}

}  // namespace anyrate
