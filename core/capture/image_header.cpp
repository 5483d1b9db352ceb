// PNG: W3C, Portable Network Graphics, sections 5.2 and 11.2.2. JPEG: ITU-T T.81, annex B.
#include "core/capture/image_header.h"

#include <algorithm>
#include <array>
#include <boost/crc.hpp>
#include <cstddef>

namespace anyrate {
namespace {

using Bytes = std::span<const std::uint8_t>;

std::uint32_t big_endian(Bytes bytes, std::size_t at, std::size_t n_bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < n_bytes; ++i) value = value << 8 | bytes[at + i];
    return value;
}

std::optional<ImageHeader> make_header(ImageKind kind, std::uint32_t width, std::uint32_t height) {
    constexpr std::uint32_t largest = 0x7FFFFFFF;  // of both formats and of int
    if (width == 0 || height == 0 || width > largest || height > largest) return std::nullopt;
    return ImageHeader{kind, static_cast<int>(width), static_cast<int>(height)};
}

bool is_png(Bytes bytes) {
    constexpr std::array<std::uint8_t, 16> front = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n',
                                                    0,    0,   0,   13,  'I',  'H',  'D',  'R'};
    return bytes.size() >= front.size() && std::equal(front.begin(), front.end(), bytes.begin());
}

std::optional<ImageHeader> read_png_header(Bytes bytes) {
    if (bytes.size() < 24) return std::nullopt;
    return make_header(ImageKind::png, big_endian(bytes, 16, 4), big_endian(bytes, 20, 4));
}

/// PNG's checksum (section 5.5).
std::uint32_t crc32(Bytes bytes) {
    boost::crc_32_type crc;
    crc.process_bytes(bytes.data(), bytes.size());
    return crc.checksum();
}

constexpr std::uint8_t jpeg_start = 0xD8, jpeg_end = 0xD9, jpeg_scan = 0xDA;

bool is_jpeg(Bytes bytes) {
    return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == jpeg_start && bytes[2] == 0xFF;
}

/// Steps from marker to marker of a JPEG file, over segments and the coded data between them.
class JpegMarkers {
public:
    explicit JpegMarkers(Bytes bytes) : bytes_(bytes) {}

    /// The next marker's code; nullopt at the end of the bytes.
    std::optional<std::uint8_t> next() {
        for (; at_ + 1 < bytes_.size(); ++at_) {
            // Within coded data FF 00 is a data byte FF, and RST0..7 (D0..D7) only synchronise; FF FF is padding.
            const std::uint8_t code = bytes_[at_ + 1];
            const bool is_data = code == 0x00 || (code >= 0xD0 && code <= 0xD7);
            if (bytes_[at_] != 0xFF || code == 0xFF || is_data) continue;
            at_ += 2;
            segment_ = at_;
            return code;
        }
        return std::nullopt;
    }

    /// The segment after the marker, its length field included; empty if it is cut off.
    Bytes segment() const {
        if (segment_ + 2 > bytes_.size()) return {};
        const std::size_t length = big_endian(bytes_, segment_, 2);
        return length < 2 || length > bytes_.size() - segment_ ? Bytes{} : bytes_.subspan(segment_, length);
    }

    void skip_segment() { at_ = segment_ + segment().size(); }

private:
    Bytes bytes_;
    std::size_t at_ = 2, segment_ = 2;  // after the start of image
};

/// A marker that starts a frame: SOF0..15 but for DHT (C4), JPG (C8) and DAC (CC).
bool is_frame_start(std::uint8_t code) {
    return code >= 0xC0 && code <= 0xCF && code != 0xC4 && code != 0xC8 && code != 0xCC;
}

std::optional<ImageHeader> read_jpeg_header(Bytes bytes) {
    JpegMarkers markers(bytes);
    while (const auto code = markers.next()) {
        const Bytes segment = markers.segment();  // of a frame: length 2, precision 1, height 2, width 2
        if (is_frame_start(*code)) {
            if (segment.size() < 7) return std::nullopt;
            return make_header(ImageKind::jpeg, big_endian(segment, 5, 2), big_endian(segment, 3, 2));
        }
        if (*code == jpeg_end || *code == jpeg_scan || segment.empty()) return std::nullopt;
        markers.skip_segment();
    }
    return std::nullopt;
}

}  // namespace

std::optional<ImageHeader> read_image_header(Bytes bytes) {
    if (is_png(bytes)) return read_png_header(bytes);
    if (is_jpeg(bytes)) return read_jpeg_header(bytes);
    return std::nullopt;
}

bool png_is_whole(Bytes bytes) {
    constexpr std::size_t signature = 8, around = 12;                         // length, type, checksum
    constexpr std::uint32_t data_chunk = 0x49444154, end_chunk = 0x49454E44;  // "IDAT", "IEND"
    if (!is_png(bytes)) return false;
    bool has_data = false;
    for (std::size_t at = signature; bytes.size() - at >= around;) {
        const std::size_t length = big_endian(bytes, at, 4);
        if (length > bytes.size() - at - around) return false;
        const std::uint32_t type = big_endian(bytes, at + 4, 4);
        const bool is_critical = (type >> 24 & 0x20) == 0;  // bit 5 of the first letter: upper case
        if (is_critical && crc32(bytes.subspan(at + 4, 4 + length)) != big_endian(bytes, at + 8 + length, 4))
            return false;
        has_data = has_data || type == data_chunk;
        if (type == end_chunk) return has_data;
        at += around + length;
    }
    return false;
}

bool jpeg_is_complete(Bytes bytes) {
    if (!is_jpeg(bytes)) return false;
    JpegMarkers markers(bytes);
    while (const auto code = markers.next()) {
        if (*code == jpeg_end) return true;
        if (markers.segment().empty()) return false;
        markers.skip_segment();
    }
    return false;
}

}  // namespace anyrate
