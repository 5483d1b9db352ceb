#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// What the face gaps of a batch start from.
inline constexpr std::int32_t no_previous_face = -1;

/// The payload of a refine frame (proto/FORMAT.md, "Payloads").
/// @param records        1 to max_splits_per_frame; runs of ascending faces cost least
/// @param previous_face  last face of the packet before; no_previous_face if a batch starts here
/// @param n_faces        of the mesh before the first record
/// @throws InputError if a record's face is not there at its turn, or a scalar exceeds 2^25 in magnitude
std::vector<std::byte> encode_refine(std::span<const SplitRecord> records, std::int32_t previous_face,
                                     std::int32_t n_faces);

/// @throws DecodeError if the payload is not a packet of exactly n_splits records of faces that are there at their turn
std::vector<SplitRecord> decode_refine(std::span<const std::byte> payload, std::size_t n_splits,
                                       std::int32_t previous_face, std::int32_t n_faces);

}  // namespace anyrate
