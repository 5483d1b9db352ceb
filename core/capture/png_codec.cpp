#include "core/capture/png_codec.h"

#include <png.h>

#include <csetjmp>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>

namespace anyrate {
namespace {

/// What is left of a file.
struct Source {
    std::span<const std::uint8_t> rest;
};

void read_from(png_structp png, png_bytep to, std::size_t n) {
    auto& rest = static_cast<Source*>(png_get_io_ptr(png))->rest;
    if (n > rest.size()) png_error(png, "the file ends");
    std::memcpy(to, rest.data(), n);
    rest = rest.subspan(n);
}

[[noreturn]] void leave(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void ignore(png_structp, png_const_charp) {}

/// libpng's two structures of a file that is read.
class Reader {
public:
    explicit Reader(std::span<const std::uint8_t> bytes) : source_{bytes} {
        png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, leave, ignore);
        if (png_) info_ = png_create_info_struct(png_);
        if (!info_) {
            png_destroy_read_struct(&png_, nullptr, nullptr);
            throw std::bad_alloc();
        }
        png_set_read_fn(png_, &source_, read_from);
    }
    ~Reader() { png_destroy_read_struct(&png_, &info_, nullptr); }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

    /// libpng leaves a function from within by longjmp, so nothing of these two may need a destructor.
    /// @param rows  gets the size
    /// @return whether the header could be read
    bool read_header(PixelRows& rows) {
        if (setjmp(png_jmpbuf(png_))) return false;
        png_read_info(png_, info_);
        png_set_expand(png_);
        png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        rows.width = static_cast<int>(png_get_image_width(png_, info_));
        rows.height = static_cast<int>(png_get_image_height(png_, info_));
        rows.n_channels = png_get_channels(png_, info_);
        rows.bytes_per_channel = png_get_bit_depth(png_, info_) / 8;
        return true;
    }

    /// @param pointers  to each row of the image
    bool read_rows(png_bytepp pointers) {
        if (setjmp(png_jmpbuf(png_))) return false;
        png_read_image(png_, pointers);
        png_read_end(png_, nullptr);
        return true;
    }

private:
    Source source_;
    png_structp png_ = nullptr;
    png_infop info_ = nullptr;
};

}  // namespace

std::optional<PixelRows> decode_png(std::span<const std::uint8_t> bytes, int width, int height) {
    Reader reader(bytes);
    PixelRows rows;
    if (!reader.read_header(rows) || rows.width != width || rows.height != height) return std::nullopt;
    rows.bytes.resize(rows.n_pixels() * rows.bytes_per_pixel());
    std::vector<png_bytep> pointers(static_cast<std::size_t>(height));
    for (std::size_t y = 0; y < pointers.size(); ++y) pointers[y] = rows.bytes.data() + y * rows.bytes_per_row();
    if (!reader.read_rows(pointers.data())) return std::nullopt;
    return rows;
}

std::vector<std::uint8_t> encode_png(const PixelRows& rows) {
    constexpr png_uint_32 formats[] = {PNG_FORMAT_GRAY, PNG_FORMAT_GA, PNG_FORMAT_RGB, PNG_FORMAT_RGBA};
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(rows.width);
    image.height = static_cast<png_uint_32>(rows.height);
    image.format = formats[rows.n_channels - 1];
    image.flags = PNG_IMAGE_FLAG_FAST;
    std::vector<std::uint8_t> bytes(PNG_IMAGE_PNG_SIZE_MAX(image));
    png_alloc_size_t n_bytes = bytes.size();
    if (!png_image_write_to_memory(&image, bytes.data(), &n_bytes, 0, rows.bytes.data(), 0, nullptr))
        throw std::runtime_error(std::string("libpng cannot write an image: ") + image.message);
    bytes.resize(n_bytes);
    return bytes;
}

}  // namespace anyrate
