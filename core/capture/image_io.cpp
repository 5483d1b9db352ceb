#include "core/capture/image_io.h"

#include <limits>
#include <string>

#include "core/capture/jpeg_codec.h"
#include "core/capture/png_codec.h"
#include "core/error.h"

namespace anyrate {
namespace {

PixelRows decode(std::span<const std::uint8_t> bytes, const ImageHeader& header) {
    const bool is_png = header.kind == ImageKind::png;
    if (bytes.size() > std::numeric_limits<int>::max()) throw InputError("more than 2 GiB; expected a photograph");
    std::optional<PixelRows> rows;
    if (is_png)
        rows = decode_png(bytes, header.width, header.height);
    else if (jpeg_is_complete(bytes))
        rows = decode_jpeg(bytes, header.width, header.height);
    if (!rows)
        throw InputError(std::string("the ") + (is_png ? "PNG" : "JPEG") +
                         " data is cut off or damaged; expected a complete file that can be decoded");
    return std::move(*rows);
}

/// Calls set(i, pixel) for the i-th pixel in row-major order, `pixel` pointing to its bytes.
template <class Set>
void for_each_pixel(const PixelRows& rows, const Set& set) {
    const std::uint8_t* pixel = rows.bytes.data();
    for (std::size_t i = 0; i < rows.n_pixels(); ++i, pixel += rows.bytes_per_pixel()) set(i, pixel);
}

/// The high byte of every channel.
ColourImage to_colour(const PixelRows& rows) {
    ColourImage image(rows.width, rows.height);
    const int g = rows.n_channels < 3 ? 0 : rows.bytes_per_channel, b = 2 * g;  // grey is all three
    for_each_pixel(rows, [&](std::size_t i, const std::uint8_t* pixel) {
        image.pixels[i] = {pixel[0], pixel[g], pixel[b]};
    });
    return image;
}

MaskImage to_mask(const PixelRows& rows, std::uint8_t smallest_object_value) {
    MaskImage mask(rows.width, rows.height);
    const int n_colour_bytes = (rows.n_channels < 3 ? 1 : 3) * rows.bytes_per_channel;
    for_each_pixel(rows, [&](std::size_t i, const std::uint8_t* pixel) {
        for (int k = 0; k < n_colour_bytes; ++k)
            if (pixel[k] >= smallest_object_value) mask.pixels[i] = 255;
    });
    return mask;
}

MaskImage opaque_part(const PixelRows& rows) {
    MaskImage mask(rows.width, rows.height);
    const int alpha = (rows.n_channels - 1) * rows.bytes_per_channel;
    for_each_pixel(rows, [&](std::size_t i, const std::uint8_t* pixel) {
        if (pixel[alpha] >= 128) mask.pixels[i] = 255;
    });
    return mask;
}

PixelRows to_rows(const ColourImage& image) {
    PixelRows rows{image.width, image.height, 3, 1, {}};
    rows.bytes.reserve(3 * image.pixels.size());
    for (const Rgb8& colour : image.pixels) rows.bytes.insert(rows.bytes.end(), {colour.r, colour.g, colour.b});
    return rows;
}

}  // namespace

ColourImage decode_colour(std::span<const std::uint8_t> bytes, const ImageHeader& header) {
    return to_colour(decode(bytes, header));
}

CutOut decode_cut_out(std::span<const std::uint8_t> bytes, const ImageHeader& header) {
    const PixelRows rows = decode(bytes, header);
    CutOut result{to_colour(rows), std::nullopt};
    if (rows.has_alpha()) result.mask = opaque_part(rows);
    return result;
}

MaskImage decode_mask(std::span<const std::uint8_t> bytes, const ImageHeader& header) {
    return to_mask(decode(bytes, header), header.kind == ImageKind::jpeg ? 128 : 1);
}

std::vector<std::uint8_t> encode_png(const ColourImage& image) { return encode_png(to_rows(image)); }

std::vector<std::uint8_t> encode_png(const MaskImage& mask) {
    PixelRows rows{mask.width, mask.height, 1, 1, mask.pixels};
    for (std::uint8_t& value : rows.bytes) value = value != 0 ? 255 : 0;
    return encode_png(rows);
}

std::vector<std::uint8_t> encode_jpeg(const ColourImage& image, int quality) {
    return encode_jpeg(to_rows(image), quality);
}

}  // namespace anyrate
