#pragma once
// Encoded bytes to plain images and back. 8 and 16 bits a channel, grey, palette and colour are read; 16 bits keep
// their high byte; embedded orientation and colour profiles are ignored (calibration saw the stored pixels).
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/capture/image.h"
#include "core/capture/image_header.h"

namespace anyrate {

struct CutOut {
    ColourImage image;
    std::optional<MaskImage> mask;  ///< 255 where alpha is at least one half, else 0; nullopt without an alpha channel
};

/// @param bytes   a whole PNG or JPEG file
/// @param header  read_image_header() of it; check its size against a limit first
/// @throws InputError the pixels cannot be decoded; the message says why, but not the file's name
ColourImage decode_colour(std::span<const std::uint8_t> bytes, const ImageHeader& header);
CutOut decode_cut_out(std::span<const std::uint8_t> bytes, const ImageHeader& header);

/// 255 where any colour channel is not 0, else 0. In a JPEG, whose blocks ring around a silhouette, where any is at
/// least 128.
MaskImage decode_mask(std::span<const std::uint8_t> bytes, const ImageHeader& header);

/// A PNG file. A mask is written as 0 and 255.
std::vector<std::uint8_t> encode_png(const ColourImage& image);
std::vector<std::uint8_t> encode_png(const MaskImage& mask);

/// A JPEG file. @param quality  from 1 to 100, as libjpeg means it
std::vector<std::uint8_t> encode_jpeg(const ColourImage& image, int quality);

}  // namespace anyrate
