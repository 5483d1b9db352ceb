#include "proto/base_codec.h"

#include <string>

#include "core/error.h"
#include "proto/draco_io.h"

namespace anyrate {

namespace {

/// A payload cannot ask for more memory than so many vertices and faces a byte: even a regular sphere takes more than a
/// bit a vertex.
constexpr std::size_t max_vertices_per_byte = 64, max_faces_per_byte = 128;

}  // namespace

std::vector<std::byte> encode_base(const BaseMesh& base, int base_shift) {
    BaseMesh shifted{{}, base.triangles};
    const std::int32_t unit = std::int32_t{1} << base_shift;
    for (const GridPoint& p : base.positions) {
        if (p.x % unit != 0 || p.y % unit != 0 || p.z % unit != 0) {
            throw InputError("base: expected positions that are multiples of " + std::to_string(unit) +
                             " grid units (base shift " + std::to_string(base_shift) + ")");
        }
        shifted.positions.push_back({p.x / unit, p.y / unit, p.z / unit});
    }
    return encode_draco_mesh(shifted);
}

BaseMesh decode_base(std::span<const std::byte> payload, const Header& header) {
    if (header.n_base_vertices > max_vertices_per_byte * payload.size() ||
        header.n_base_faces > max_faces_per_byte * payload.size()) {
        throw DecodeError("base: " + std::to_string(payload.size()) + " bytes cannot hold " +
                          std::to_string(header.n_base_vertices) + " vertices and " +
                          std::to_string(header.n_base_faces) + " faces");
    }
    BaseMesh base = decode_draco_mesh(payload, header.n_base_vertices, header.n_base_faces);
    const std::int32_t limit = (std::int32_t{1} << header.grid.bits) >> header.grid.base_shift;
    for (GridPoint& p : base.positions) {
        for (std::int32_t* x : {&p.x, &p.y, &p.z}) {
            if (*x < 0 || *x >= limit) throw DecodeError("base: a position leaves the grid");
            *x <<= header.grid.base_shift;
        }
    }
    return base;
}

}  // namespace anyrate
