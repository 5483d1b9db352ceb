#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

namespace anyrate {

/// One row per base, refine and colour frame, in file order (16 bytes on the wire).
struct IndexRow {
    std::uint32_t n_vertices = 0;  ///< after the frame
    std::uint32_t end = 0;         ///< offset of the frame's end, relative to the first frame (the base)
    float mean_distortion = 0;     ///< after the frame
    float max_distortion = 0;
    friend bool operator==(const IndexRow&, const IndexRow&) = default;
};

/// How much of a model somebody wants.
struct VertexBudget {
    std::uint32_t n_vertices;
};
struct ByteBudget {
    std::uint64_t n_bytes;
};  ///< of the whole prefix, header and index included
struct DistortionBudget {
    double distortion;
};  ///< at most, if the log gets there
using Budget = std::variant<VertexBudget, ByteBudget, DistortionBudget>;

/// Number of rows (frames) of the prefix that answers a budget; never less than the base and its colours.
/// @param frames_begin offset of the first frame in the file
std::size_t rows_for_budget(std::span<const IndexRow> rows, const Budget& budget, std::uint64_t frames_begin);

/// End of that prefix as an offset in the file.
std::uint64_t prefix_end(std::span<const IndexRow> rows, const Budget& budget, std::uint64_t frames_begin);

/// The rows as the payload of an index frame, and back. @throws DecodeError
std::vector<std::byte> encode_index_rows(std::span<const IndexRow> rows);
std::vector<IndexRow> decode_index_rows(std::span<const std::byte> payload);

/// The rows as the bytes of the side index `<log>.idx` (FORMAT.md, "Side index"), and back.
/// @throws DecodeError
std::vector<std::byte> encode_index(std::uint64_t log_id, std::span<const IndexRow> rows);
struct SideIndex {
    std::uint64_t log_id = 0;
    std::vector<IndexRow> rows;
};
SideIndex decode_index(std::span<const std::byte> bytes);

}  // namespace anyrate
