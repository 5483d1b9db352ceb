#pragma once
// The one door to libjpeg-turbo.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/capture/pixel_rows.h"

namespace anyrate {

/// Grey or colour; cyan, magenta, yellow and black, as Adobe's programs store them, become colour. Embedded orientation
/// is ignored.
/// @param bytes  a whole JPEG file
/// @return nullopt if it is damaged so that there are no pixels, or of another size
std::optional<PixelRows> decode_jpeg(std::span<const std::uint8_t> bytes, int width, int height);

/// A JPEG file whose colours have half the resolution. @param rows  grey or colour, 8 bits a channel
/// @param quality  from 1 to 100, as libjpeg means it
std::vector<std::uint8_t> encode_jpeg(const PixelRows& rows, int quality);

}  // namespace anyrate
