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
/// @param records        1 to max_splits_per_frame, faces ascending and all above previous_face
/// @param previous_face  last face of the batch's packet before; no_previous_face if the batch starts here
/// @throws InputError if the faces do not ascend, or a scalar exceeds 2^25 in magnitude
std::vector<std::byte> encode_refine(std::span<const SplitRecord> records, std::int32_t previous_face);

/// @throws DecodeError if the payload is not such a packet of exactly n_splits records
std::vector<SplitRecord> decode_refine(std::span<const std::byte> payload, std::size_t n_splits,
                                       std::int32_t previous_face);

}  // namespace anyrate
