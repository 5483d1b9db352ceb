#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/progressive/refinable_mesh.h"
#include "proto/header.h"

namespace anyrate {

/// The payload of a base frame (proto/FORMAT.md, "Payloads"). Positions must be multiples of 2^base_shift.
/// @throws InputError if one is not
std::vector<std::byte> encode_base(const BaseMesh& base, int base_shift);

/// The base, numbered as every reader numbers it. @throws DecodeError if it has not the counts of the header. Whether
/// the mesh is closed and on the grid is for RefinableMesh to check.
BaseMesh decode_base(std::span<const std::byte> payload, const Header& header);

}  // namespace anyrate
