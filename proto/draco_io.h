#pragma once
// The only door to Draco: integers in, stock Draco bytes out, and back. What comes back was checked to have exactly the
// layout that was asked for before Draco allocated it; whatever Draco throws or reports leaves as DecodeError.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// A generic attribute of a point cloud: n_components int32 per point, point by point.
struct IntAttribute {
    int n_components = 1;
    std::vector<std::int32_t> values;
};

/// A sequential point cloud without prediction. All attributes have n_points points, n_points > 0.
/// @throws InputError if a value exceeds 2^25 in magnitude (Draco 1.5.5 throws from 2^30 on, and counts
///         symbols in a table as long as the largest)
std::vector<std::byte> encode_point_cloud(std::size_t n_points, std::span<const IntAttribute> attributes);

/// @param n_components what each attribute must have, in order
/// @throws DecodeError if the bytes are not such a cloud of exactly n_points points, or a value exceeds 2^25 in
/// magnitude
std::vector<IntAttribute> decode_point_cloud(std::span<const std::byte> bytes, std::size_t n_points,
                                             std::span<const int> n_components);

/// An edgebreaker mesh with int32 positions, lossless. Draco renumbers vertices and faces.
std::vector<std::byte> encode_draco_mesh(const BaseMesh& mesh);
/// @throws DecodeError if the bytes are not such a mesh with exactly these counts
BaseMesh decode_draco_mesh(std::span<const std::byte> bytes, std::size_t n_vertices, std::size_t n_faces);

}  // namespace anyrate
