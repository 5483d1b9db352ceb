#include "proto/index.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <string>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/crc32c.h"

namespace anyrate {

namespace {

constexpr std::size_t row_size = 16;
constexpr std::array<std::uint8_t, 8> magic = {0x89, 'A', 'R', 'I', 0x0D, 0x0A, 0x1A, 0x0A};

/// So many rows, and those behind them that add no vertex: the colours of the last one.
std::size_t with_colours(std::span<const IndexRow> rows, std::size_t n_rows) {
    while (n_rows < rows.size() && rows[n_rows].n_vertices == rows[n_rows - 1].n_vertices) ++n_rows;
    return n_rows;
}

/// Rows up to the first that is good enough, with its colours; all rows if none is.
template <class IsEnough>
std::size_t rows_up_to(std::span<const IndexRow> rows, IsEnough is_enough) {
    const auto found = std::find_if(rows.begin(), rows.end(), is_enough);
    if (found == rows.end()) return rows.size();
    return with_colours(rows, static_cast<std::size_t>(found - rows.begin()) + 1);
}

struct CountRows {
    std::span<const IndexRow> rows;
    std::uint64_t frames_begin;

    std::size_t operator()(const VertexBudget& budget) const {
        return rows_up_to(rows,
                          [&](const IndexRow& row) { return std::uint64_t{row.n_vertices} + 2 >= budget.n_vertices; });
    }
    std::size_t operator()(const ByteBudget& budget) const {
        const auto fits = [&](const IndexRow& row) { return frames_begin + row.end <= budget.n_bytes; };
        return static_cast<std::size_t>(std::partition_point(rows.begin(), rows.end(), fits) - rows.begin());
    }
    std::size_t operator()(const DistortionBudget& budget) const {
        return rows_up_to(rows, [&](const IndexRow& row) { return row.mean_distortion <= budget.distortion; });
    }
};

}  // namespace

std::size_t rows_for_budget(std::span<const IndexRow> rows, const Budget& budget, std::uint64_t frames_begin) {
    if (rows.empty()) return 0;
    return std::max(with_colours(rows, 1), std::visit(CountRows{rows, frames_begin}, budget));
}

std::uint64_t prefix_end(std::span<const IndexRow> rows, const Budget& budget, std::uint64_t frames_begin) {
    const std::size_t n_rows = rows_for_budget(rows, budget, frames_begin);
    return frames_begin + (n_rows == 0 ? 0 : rows[n_rows - 1].end);
}

std::vector<std::byte> encode_index_rows(std::span<const IndexRow> rows) {
    ByteWriter out;
    for (const IndexRow& row : rows) {
        out.put(row.n_vertices);
        out.put(row.end);
        out.put(row.mean_distortion);
        out.put(row.max_distortion);
    }
    return out.take();
}

std::vector<IndexRow> decode_index_rows(std::span<const std::byte> payload) {
    if (payload.size() % row_size != 0) {
        throw DecodeError("index: expected rows of 16 bytes, got " + std::to_string(payload.size()) + " bytes");
    }
    ByteReader in(payload, "index");
    std::vector<IndexRow> rows(payload.size() / row_size);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        rows[i].n_vertices = in.take<std::uint32_t>();
        rows[i].end = in.take<std::uint32_t>();
        rows[i].mean_distortion = in.take<float>();
        rows[i].max_distortion = in.take<float>();
        if (i > 0 && (rows[i].n_vertices < rows[i - 1].n_vertices || rows[i].end < rows[i - 1].end)) {
            throw DecodeError("index row " + std::to_string(i) + ": expected vertices and ends that never decrease");
        }
    }
    return rows;
}

std::vector<std::byte> encode_index(std::uint64_t log_id, std::span<const IndexRow> rows) {
    ByteWriter out;
    out.put(std::as_bytes(std::span(magic)));
    out.put(log_id);
    out.put(static_cast<std::uint32_t>(rows.size()));
    out.put(std::uint32_t{0});
    out.put(encode_index_rows(rows));
    out.put(crc32c(out.bytes()));
    return out.take();
}

SideIndex decode_index(std::span<const std::byte> bytes) {
    ByteReader in(bytes, "side index");
    if (!std::ranges::equal(in.take_bytes(magic.size()), std::as_bytes(std::span(magic)))) {
        throw DecodeError("side index: expected the magic bytes 89 'ARI'");
    }
    SideIndex index;
    index.log_id = in.take<std::uint64_t>();
    const auto n_rows = in.take<std::uint32_t>();
    in.take<std::uint32_t>();
    const std::uint64_t expected = std::uint64_t{n_rows} * row_size + sizeof(std::uint32_t);
    if (in.remaining() != expected) {
        throw DecodeError("side index: expected " + std::to_string(expected) + " bytes for " + std::to_string(n_rows) +
                          " rows, got " + std::to_string(in.remaining()));
    }
    const auto rows = in.take_bytes(n_rows * row_size);
    if (in.take<std::uint32_t>() != crc32c(bytes.first(bytes.size() - sizeof(std::uint32_t)))) {
        throw DecodeError("side index: wrong checksum, the index is damaged");
    }
    index.rows = decode_index_rows(rows);
    return index;
}

}  // namespace anyrate
