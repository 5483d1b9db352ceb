#include "core/capture/jpeg_codec.h"

#include <turbojpeg.h>

#include <memory>
#include <new>
#include <stdexcept>
#include <string>

namespace anyrate {
namespace {

struct Destroy {
    void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, Destroy>;

Handle owned(tjhandle handle) {
    if (!handle) throw std::bad_alloc();
    return Handle(handle);
}

/// Cyan, magenta, yellow and black, all of them inverted, to red, green and blue.
PixelRows to_rgb(const PixelRows& cmyk) {
    PixelRows rgb{cmyk.width, cmyk.height, 3, 1, {}};
    rgb.bytes.reserve(rgb.n_pixels() * 3);
    for (std::size_t i = 0; i < cmyk.bytes.size(); i += 4)
        for (std::size_t c = 0; c < 3; ++c)
            rgb.bytes.push_back(static_cast<std::uint8_t>((cmyk.bytes[i + c] * cmyk.bytes[i + 3] + 127) / 255));
    return rgb;
}

}  // namespace

std::optional<PixelRows> decode_jpeg(std::span<const std::uint8_t> bytes, int width, int height) {
    const Handle jpeg = owned(tjInitDecompress());
    PixelRows rows;
    int subsampling = 0, colours = 0;
    if (tjDecompressHeader3(jpeg.get(), bytes.data(), bytes.size(), &rows.width, &rows.height, &subsampling,
                            &colours) != 0 ||
        rows.width != width || rows.height != height)
        return std::nullopt;
    const bool is_cmyk = colours == TJCS_CMYK || colours == TJCS_YCCK;
    rows.n_channels = colours == TJCS_GRAY ? 1 : is_cmyk ? 4 : 3;
    rows.bytes.resize(rows.n_pixels() * rows.bytes_per_pixel());
    const int format = colours == TJCS_GRAY ? TJPF_GRAY : is_cmyk ? TJPF_CMYK : TJPF_RGB;
    // A warning is of data that a decoder gets over; whether the end is there, jpeg_is_complete() tells.
    if (tjDecompress2(jpeg.get(), bytes.data(), bytes.size(), rows.bytes.data(), width, 0, height, format, 0) != 0 &&
        tjGetErrorCode(jpeg.get()) != TJERR_WARNING)
        return std::nullopt;
    if (is_cmyk) return to_rgb(rows);
    return rows;
}

std::vector<std::uint8_t> encode_jpeg(const PixelRows& rows, int quality) {
    const Handle jpeg = owned(tjInitCompress());
    const bool is_grey = rows.n_channels == 1;
    const int subsampling = is_grey ? TJSAMP_GRAY : TJSAMP_420;
    std::vector<std::uint8_t> bytes(tjBufSize(rows.width, rows.height, subsampling));
    unsigned char* to = bytes.data();
    unsigned long n_bytes = bytes.size();
    if (tjCompress2(jpeg.get(), rows.bytes.data(), rows.width, 0, rows.height, is_grey ? TJPF_GRAY : TJPF_RGB, &to,
                    &n_bytes, subsampling, quality, TJFLAG_NOREALLOC | TJFLAG_ACCURATEDCT) != 0)
        throw std::runtime_error(std::string("libjpeg-turbo cannot write an image: ") + tjGetErrorStr2(jpeg.get()));
    bytes.resize(n_bytes);
    return bytes;
}

}  // namespace anyrate
