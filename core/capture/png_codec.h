#pragma once
// The one door to libpng.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/capture/pixel_rows.h"

namespace anyrate {

/// Palettes become colours, a transparent colour becomes alpha, and channels of fewer than 8 bits get 8; colour
/// profiles and gamma are ignored.
/// @param bytes  a whole PNG file
/// @return nullopt if it is cut off or damaged, or of another size
std::optional<PixelRows> decode_png(std::span<const std::uint8_t> bytes, int width, int height);

/// A PNG file, packed for speed. @param rows  8 bits a channel
std::vector<std::uint8_t> encode_png(const PixelRows& rows);

}  // namespace anyrate
