#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "proto/colour_state.h"

namespace anyrate {

/// The payload of a colour frame (proto/FORMAT.md, "Payloads"); at least one residual.
std::vector<std::byte> encode_colour(std::span<const ColourResidual> residuals);

/// @throws DecodeError if the payload is not a packet of exactly n_vertices residuals, or one exceeds 511 in magnitude
std::vector<ColourResidual> decode_colour(std::span<const std::byte> payload, std::size_t n_vertices);

}  // namespace anyrate
