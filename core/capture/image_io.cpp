#include "core/capture/image_io.h"

#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>

#include "core/error.h"

namespace anyrate {
namespace {

const char* name_of(ImageKind kind) { return kind == ImageKind::png ? "PNG" : "JPEG"; }

cv::Mat decode(std::span<const std::uint8_t> bytes, const ImageHeader& header, int flags) {
    const std::string damaged = std::string("the ") + name_of(header.kind) +
                                " data is cut off or damaged; expected a complete file that can be decoded";
    if (bytes.size() > std::numeric_limits<int>::max()) throw InputError("more than 2 GiB; expected a photograph");
    if (header.kind == ImageKind::jpeg && !jpeg_is_complete(bytes)) throw InputError(damaged);
    cv::Mat pixels;
    try {
        // OpenCV wants a mutable pointer for its matrix header, but only reads.
        const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<std::uint8_t*>(bytes.data()));
        pixels = cv::imdecode(encoded, flags);
    } catch (const cv::Exception& refusal) {
        // Its own limits (OPENCV_IO_MAX_IMAGE_PIXELS, _WIDTH, _HEIGHT) hold besides LoadOptions::max_pixels.
        throw InputError("OpenCV refuses to decode it (" + refusal.err + "); expected a " + name_of(header.kind) +
                         " within OpenCV's limits");
    }
    if (pixels.empty() || pixels.cols != header.width || pixels.rows != header.height) throw InputError(damaged);
    return pixels;
}

/// Calls set(i, pixel) for the i-th pixel in row-major order, `pixel` pointing to its channels.
template <class Channel, class Set>
void for_each_pixel(const cv::Mat& pixels, const Set& set) {
    std::size_t i = 0;
    for (int y = 0; y < pixels.rows; ++y) {
        const Channel* row = pixels.ptr<Channel>(y);
        for (int x = 0; x < pixels.cols; ++x) set(i++, row + static_cast<std::ptrdiff_t>(x) * pixels.channels());
    }
}

/// The high byte of a channel's value.
std::uint8_t to_8_bits(std::uint8_t value) { return value; }
std::uint8_t to_8_bits(std::uint16_t value) { return static_cast<std::uint8_t>(value >> 8); }

template <class Channel>
CutOut to_cut_out(const cv::Mat& pixels) {
    CutOut result{ColourImage(pixels.cols, pixels.rows), std::nullopt};
    const int n_channels = pixels.channels();
    if (n_channels == 4) result.mask = MaskImage(pixels.cols, pixels.rows);
    for_each_pixel<Channel>(pixels, [&](std::size_t i, const Channel* bgra) {
        const Channel *g = n_channels == 1 ? bgra : bgra + 1, *r = n_channels == 1 ? bgra : bgra + 2;
        result.image.pixels[i] = {to_8_bits(*r), to_8_bits(*g), to_8_bits(*bgra)};
        if (result.mask) result.mask->pixels[i] = to_8_bits(bgra[3]) >= 128 ? 255 : 0;
    });
    return result;
}

template <class Channel>
MaskImage to_mask(const cv::Mat& pixels, Channel smallest_object_value) {
    MaskImage mask(pixels.cols, pixels.rows);
    const int n_colours = pixels.channels() == 4 ? 3 : pixels.channels();
    for_each_pixel<Channel>(pixels, [&](std::size_t i, const Channel* channels) {
        for (int c = 0; c < n_colours; ++c)
            if (channels[c] >= smallest_object_value) mask.pixels[i] = 255;
    });
    return mask;
}

cv::Mat to_bgr(const ColourImage& image) {
    cv::Mat pixels(image.height, image.width, CV_8UC3);
    std::size_t i = 0;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const Rgb8 colour = image.pixels[i++];
            pixels.at<cv::Vec3b>(y, x) = {colour.b, colour.g, colour.r};
        }
    }
    return pixels;
}

std::vector<std::uint8_t> encode_png(const cv::Mat& pixels) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".png", pixels, bytes);
    return bytes;
}

}  // namespace

ColourImage decode_colour(std::span<const std::uint8_t> bytes, const ImageHeader& header) {
    return to_cut_out<std::uint8_t>(decode(bytes, header, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION)).image;
}

CutOut decode_cut_out(std::span<const std::uint8_t> bytes, const ImageHeader& header) {
    const cv::Mat pixels = decode(bytes, header, cv::IMREAD_UNCHANGED);
    return pixels.depth() == CV_16U ? to_cut_out<std::uint16_t>(pixels) : to_cut_out<std::uint8_t>(pixels);
}

MaskImage decode_mask(std::span<const std::uint8_t> bytes, const ImageHeader& header) {
    const cv::Mat pixels = decode(bytes, header, cv::IMREAD_UNCHANGED);
    if (pixels.depth() == CV_16U) return to_mask<std::uint16_t>(pixels, 1);
    return to_mask<std::uint8_t>(pixels, header.kind == ImageKind::jpeg ? 128 : 1);
}

std::vector<std::uint8_t> encode_png(const ColourImage& image) { return encode_png(to_bgr(image)); }

std::vector<std::uint8_t> encode_jpeg(const ColourImage& image, int quality) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", to_bgr(image), bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
    return bytes;
}

std::vector<std::uint8_t> encode_png(const MaskImage& mask) {
    cv::Mat pixels(mask.height, mask.width, CV_8UC1);
    std::size_t i = 0;
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x) pixels.at<std::uint8_t>(y, x) = mask.pixels[i++] != 0 ? 255 : 0;
    return encode_png(pixels);
}

}  // namespace anyrate
