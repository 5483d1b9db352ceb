#pragma once
#include <cstdint>
#include <optional>
#include <span>

namespace anyrate {

enum class ImageKind { png, jpeg };

/// What a PNG or JPEG file says about itself before its first pixel.
struct ImageHeader {
    ImageKind kind = ImageKind::png;
    int width = 0, height = 0;  ///< pixels, both positive
};

/// @param bytes  the file, or the front of it
/// @return nullopt if this is neither PNG nor JPEG, or its size is not among these bytes
std::optional<ImageHeader> read_image_header(std::span<const std::uint8_t> bytes);

/// Whether a PNG file is whole: its chunks follow each other to the last, and the critical ones have their checksums.
/// So much is known without unpacking a pixel; what is packed may be wrong all the same.
/// @param bytes  a whole PNG file
bool png_is_whole(std::span<const std::uint8_t> bytes);

/// Whether the marker that ends an image is there. Decoders fill the missing rows of a JPEG with grey and do not
/// complain.
/// @param bytes  a whole JPEG file
bool jpeg_is_complete(std::span<const std::uint8_t> bytes);

}  // namespace anyrate
