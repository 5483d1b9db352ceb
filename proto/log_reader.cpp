#include "proto/log_reader.h"

#include <algorithm>
#include <limits>
#include <string>

#include "core/error.h"
#include "proto/log_order.h"

namespace anyrate {

namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

bool has_row(FrameType type) {
    return type == FrameType::base || type == FrameType::refine || type == FrameType::colour;
}

std::vector<IndexRow> rows_of_frames(const LogLayout& layout) {
    std::vector<IndexRow> rows;
    for (const FrameInfo& frame : layout.frames) {
        if (!has_row(frame.type)) continue;
        rows.push_back(
            {frame.n_vertices_after, static_cast<std::uint32_t>(frame.end() - layout.frames_begin), unknown, unknown});
    }
    return rows;
}

/// A sealed log's index must tell what its frames are; it may know more of them than a cut file has.
void check_index(const LogLayout& layout, std::span<const IndexRow> rows_found) {
    const bool fits =
        layout.ended ? layout.index.size() == rows_found.size() : layout.index.size() >= rows_found.size();
    const auto same = [](const IndexRow& a, const IndexRow& b) {
        return a.n_vertices == b.n_vertices && a.end == b.end;
    };
    if (!fits || !std::equal(rows_found.begin(), rows_found.end(), layout.index.begin(), same)) {
        throw DecodeError("index: its rows are not those of the frames behind it");
    }
}

std::span<const std::byte> prefix(std::span<const std::byte> log, const LogLayout& layout, const Budget& budget) {
    const std::uint64_t end = prefix_end(layout.index, budget, layout.frames_begin);
    return log.first(static_cast<std::size_t>(std::min(end, layout.whole_bytes)));
}

}  // namespace

LogLayout read_layout(std::span<const std::byte> log) {
    LogLayout layout;
    layout.header = decode_header(log);
    layout.whole_bytes = layout.frames_begin = layout.header.header_bytes;
    LogOrder order(layout.header);
    while (auto frame = read_frame(log.subspan(layout.whole_bytes), layout.whole_bytes)) {
        order.accept(*frame);
        layout.whole_bytes = frame->end();
        if (frame->type == FrameType::index) {
            layout.index = decode_index_rows(log.subspan(frame->begin + frame_header_size, frame->payload_bytes));
            layout.frames_begin = frame->end();
        }
        layout.frames.push_back(*frame);
    }
    layout.ended = order.ended();
    if (layout.ended && layout.whole_bytes != log.size()) throw DecodeError("bytes behind the end frame of the log");
    const std::vector<IndexRow> rows = rows_of_frames(layout);
    if (!layout.header.sealed) {
        layout.index = rows;
    } else {
        check_index(layout, rows);
    }
    return layout;
}

Mesh decode_mesh(std::span<const std::byte> log, const Budget& budget) {
    ModelDecoder decoder;
    if (const auto* vertices = std::get_if<VertexBudget>(&budget)) decoder.set_max_vertices(vertices->n_vertices);
    decoder.feed(prefix(log, read_layout(log), budget));
    return decoder.mesh();
}

std::size_t verify_log(std::span<const std::byte> log) {
    const LogLayout layout = read_layout(log);
    if (layout.whole_bytes != log.size()) {
        throw DecodeError("log: cut inside the frame at offset " + std::to_string(layout.whole_bytes) + " (behind " +
                          std::to_string(layout.frames.size()) + " whole frames)");
    }
    ModelDecoder decoder;
    decoder.feed(log);
    if (!decoder.state()) throw DecodeError("log: expected a base behind its header, found none");
    return layout.frames.size();
}

}  // namespace anyrate
