#include "proto/refine_codec.h"

#include <array>
#include <string>

#include "core/error.h"
#include "proto/draco_io.h"

namespace anyrate {

namespace {

constexpr std::array<int, 3> layout = {1, 3, 6};  // face gap, residuals, updates
constexpr std::int32_t faces_per_split = 6;

/// Without prediction Draco stores an integer as its zigzag code; the number whose code is the gap itself costs a bit
/// less.
std::int32_t fold(std::int32_t gap) { return gap % 2 == 0 ? gap / 2 : -((gap + 1) / 2); }
std::int64_t unfold(std::int32_t symbol) {
    return symbol >= 0 ? 2 * std::int64_t{symbol} : -2 * std::int64_t{symbol} - 1;
}

}  // namespace

std::vector<std::byte> encode_refine(std::span<const SplitRecord> records, std::int32_t previous_face,
                                     std::int32_t n_faces) {
    std::array<IntAttribute, 3> columns;
    for (std::size_t a = 0; a < columns.size(); ++a) columns[a].n_components = layout[a];
    for (const SplitRecord& record : records) {
        if (record.face < 0 || record.face >= n_faces) {
            throw InputError("refine packet: face " + std::to_string(record.face) + " of only " +
                             std::to_string(n_faces));
        }
        const std::int32_t gap = record.face - previous_face - 1;
        columns[0].values.push_back(fold(gap >= 0 ? gap : gap + n_faces));
        columns[1].values.insert(columns[1].values.end(), record.residual.begin(), record.residual.end());
        columns[2].values.insert(columns[2].values.end(), record.update.begin(), record.update.end());
        previous_face = record.face;
        n_faces += faces_per_split;
    }
    return encode_point_cloud(records.size(), columns);
}

std::vector<SplitRecord> decode_refine(std::span<const std::byte> payload, std::size_t n_splits,
                                       std::int32_t previous_face, std::int32_t n_faces) {
    const std::vector<IntAttribute> columns = decode_point_cloud(payload, n_splits, layout);
    std::vector<SplitRecord> records(n_splits);
    std::int64_t face = previous_face;
    for (std::size_t i = 0; i < n_splits; ++i, n_faces += faces_per_split) {
        face += unfold(columns[0].values[i]) + 1;
        if (face >= n_faces) face -= n_faces;  // the next batch starts inside the packet
        if (face >= n_faces) {
            throw DecodeError("refine packet: record " + std::to_string(i) + " names a face beyond the " +
                              std::to_string(n_faces) + " that are there");
        }
        records[i].face = static_cast<std::int32_t>(face);
        for (std::size_t k = 0; k < 3; ++k) records[i].residual[k] = columns[1].values[3 * i + k];
        for (std::size_t k = 0; k < 6; ++k) records[i].update[k] = columns[2].values[6 * i + k];
    }
    return records;
}

}  // namespace anyrate
