#include "core/capture/image_io.h"

#include <doctest/doctest.h>
#include <turbojpeg.h>

#include <cstdlib>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/error.h"

using namespace anyrate;

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes encode(const std::string& extension, const cv::Mat& pixels, const std::vector<int>& options = {}) {
    Bytes bytes;
    REQUIRE(cv::imencode(extension, pixels, bytes, options));
    return bytes;
}

/// A picture with some structure.
cv::Mat waves(int width, int height, int type) {
    cv::Mat pixels(height, width, type);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width * pixels.channels(); ++x)
            pixels.ptr<std::uint8_t>(y)[x] = static_cast<std::uint8_t>((x * 7 + y * 13) % 251);
    return pixels;
}

/// Size of the smallest front of the file that has its header.
std::size_t n_header_bytes(const Bytes& bytes) {
    std::size_t n = 0;
    while (n < bytes.size() && !read_image_header({bytes.data(), n})) ++n;
    return n;
}

}  // namespace

TEST_CASE("Image header: sizes of PNG and JPEG are read from the front of the file") {
    const Bytes png = encode(".png", waves(37, 21, CV_8UC3)), jpeg = encode(".jpg", waves(37, 21, CV_8UC3));
    const Bytes progressive = encode(".jpg", waves(37, 21, CV_8UC3), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
    for (const Bytes* bytes : {&png, &jpeg, &progressive}) {
        const auto header = read_image_header(*bytes);
        REQUIRE(header);
        CHECK(header->width == 37);
        CHECK(header->height == 21);
        CHECK(header->kind == (bytes == &png ? ImageKind::png : ImageKind::jpeg));
        CHECK(n_header_bytes(*bytes) < 400);
    }
}

TEST_CASE("Image header: no truncation reads past its end or invents a size") {
    for (const Bytes& bytes : {encode(".png", waves(5, 4, CV_8UC3)), encode(".jpg", waves(5, 4, CV_8UC3))}) {
        for (std::size_t n = 0; n <= bytes.size(); ++n) {
            const Bytes front(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n));
            const auto header = read_image_header(front);
            if (header) CHECK(header->width == 5);
            CHECK(header.has_value() == (n >= n_header_bytes(bytes)));
        }
    }
}

TEST_CASE("JPEG: complete only with its end, baseline, progressive and with restarts") {
    const std::vector<std::vector<int>> kinds = {
        {}, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}, {cv::IMWRITE_JPEG_RST_INTERVAL, 2}};
    for (const std::vector<int>& options : kinds) {
        const Bytes bytes = encode(".jpg", waves(64, 48, CV_8UC3), options);
        CHECK(jpeg_is_complete(bytes));
        for (std::size_t n = 0; n < bytes.size(); ++n) {
            const Bytes front(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n));
            CHECK_FALSE(jpeg_is_complete(front));
        }
    }
}

TEST_CASE("Image I/O: encode then decode gives the same pixels") {
    ColourImage image(7, 5);
    MaskImage mask(7, 5);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const auto v = static_cast<std::uint8_t>(i * 7);
        image.pixels[i] = {v, static_cast<std::uint8_t>(255 - v), static_cast<std::uint8_t>(v / 2)};
        mask.pixels[i] = i % 3 == 0 ? 255 : 0;
    }
    const Bytes colours = encode_png(image), silhouette = encode_png(mask);
    CHECK(decode_colour(colours, *read_image_header(colours)).pixels == image.pixels);
    CHECK(decode_mask(silhouette, *read_image_header(silhouette)).pixels == mask.pixels);
}

TEST_CASE("Image I/O: pixels are those that OpenCV reads") {
    const auto deep = [](int type) {
        cv::Mat pixels;
        waves(37, 21, type).convertTo(pixels, CV_16U, 257);
        return pixels;
    };
    const std::vector<int> progressive{cv::IMWRITE_JPEG_PROGRESSIVE, 1};
    const std::vector<Bytes> files = {encode(".png", waves(37, 21, CV_8UC1)),
                                      encode(".png", waves(37, 21, CV_8UC3)),
                                      encode(".png", waves(37, 21, CV_8UC4)),
                                      encode(".png", deep(CV_8UC1)),
                                      encode(".png", deep(CV_8UC3)),
                                      encode(".png", deep(CV_8UC4)),
                                      encode(".png", waves(37, 21, CV_8UC1), {cv::IMWRITE_PNG_BILEVEL, 1}),
                                      encode(".jpg", waves(37, 21, CV_8UC1)),
                                      encode(".jpg", waves(37, 21, CV_8UC3)),
                                      encode(".jpg", waves(37, 21, CV_8UC3), progressive)};
    for (std::size_t f = 0; f < files.size(); ++f) {
        CAPTURE(f);
        const cv::Mat colours = cv::imdecode(files[f], cv::IMREAD_COLOR);
        const cv::Mat stored = cv::imdecode(files[f], cv::IMREAD_UNCHANGED);
        const CutOut cut_out = decode_cut_out(files[f], *read_image_header(files[f]));
        CHECK(decode_colour(files[f], *read_image_header(files[f])).pixels == cut_out.image.pixels);
        REQUIRE(cut_out.mask.has_value() == (stored.channels() == 4));
        for (int y = 0; y < colours.rows; ++y)
            for (int x = 0; x < colours.cols; ++x) {
                const auto& bgr = colours.at<cv::Vec3b>(y, x);
                REQUIRE(cut_out.image(x, y) == Rgb8{bgr[2], bgr[1], bgr[0]});
                if (!cut_out.mask) continue;
                const int alpha =
                    stored.depth() == CV_16U ? stored.at<cv::Vec4w>(y, x)[3] / 256 : stored.at<cv::Vec4b>(y, x)[3];
                REQUIRE((*cut_out.mask)(x, y) == (alpha >= 128 ? 255 : 0));
            }
    }
}

TEST_CASE("Image I/O: OpenCV reads what is written") {
    ColourImage image(37, 21);
    for (int y = 0; y < 21; ++y)
        for (int x = 0; x < 37; ++x)
            image(x, y) = {static_cast<std::uint8_t>(6 * x), static_cast<std::uint8_t>(12 * y),
                           static_cast<std::uint8_t>(3 * x + 6 * y)};
    const cv::Mat png = cv::imdecode(encode_png(image), cv::IMREAD_UNCHANGED);
    const cv::Mat jpeg = cv::imdecode(encode_jpeg(image, 95), cv::IMREAD_UNCHANGED);
    REQUIRE(png.size() == cv::Size(37, 21));
    REQUIRE(jpeg.size() == cv::Size(37, 21));
    double difference = 0;
    for (int y = 0; y < 21; ++y)
        for (int x = 0; x < 37; ++x) {
            const Rgb8 colour = image(x, y);
            REQUIRE(png.at<cv::Vec3b>(y, x) == cv::Vec3b(colour.b, colour.g, colour.r));
            difference += std::abs(jpeg.at<cv::Vec3b>(y, x)[1] - colour.g);
        }
    CHECK(difference / (37 * 21) < 3);
}

TEST_CASE("Image I/O: inks are colours") {
    // What is stored is inverted, as Adobe's programs do: 255 is no ink.
    const std::vector<std::uint8_t> pixels = {255, 255, 255, 255, 0, 255, 255, 255, 255, 255, 255, 0};
    const std::vector<Rgb8> expected = {{255, 255, 255}, {0, 255, 255}, {0, 0, 0}};
    for (std::size_t i = 0; i < expected.size(); ++i) {
        std::vector<std::uint8_t> block;
        for (int k = 0; k < 64; ++k) block.insert(block.end(), pixels.begin() + 4 * i, pixels.begin() + 4 * (i + 1));
        const std::unique_ptr<void, int (*)(void*)> jpeg(tjInitCompress(), tjDestroy);
        Bytes bytes(tjBufSize(8, 8, TJSAMP_444));
        unsigned char* to = bytes.data();
        unsigned long n_bytes = bytes.size();
        REQUIRE(tjCompress2(jpeg.get(), block.data(), 8, 0, 8, TJPF_CMYK, &to, &n_bytes, TJSAMP_444, 100,
                            TJFLAG_NOREALLOC) == 0);
        bytes.resize(n_bytes);
        const Rgb8 colour = decode_colour(bytes, *read_image_header(bytes)).pixels[27];
        CHECK(std::abs(colour.r - expected[i].r) <= 4);
        CHECK(std::abs(colour.g - expected[i].g) <= 4);
        CHECK(std::abs(colour.b - expected[i].b) <= 4);
    }
}

TEST_CASE("Mask: whatever is not 0 is object, in grey of 8 and 16 bits and in colour") {
    cv::Mat grey(1, 3, CV_8UC1), deep(1, 3, CV_16UC1), colour(1, 3, CV_8UC3, cv::Scalar(0, 0, 0));
    for (int x = 0; x < 3; ++x) {
        grey.at<std::uint8_t>(0, x) = static_cast<std::uint8_t>(x);
        deep.at<std::uint16_t>(0, x) = static_cast<std::uint16_t>(x);
        if (x > 0) colour.at<cv::Vec3b>(0, x)[x] = 1;
    }
    for (const cv::Mat& pixels : {grey, deep, colour}) {
        const Bytes bytes = encode(".png", pixels);
        CHECK(decode_mask(bytes, *read_image_header(bytes)).pixels == std::vector<std::uint8_t>{0, 255, 255});
    }
}

TEST_CASE("Mask: in a JPEG the threshold is half") {
    cv::Mat halves(16, 32, CV_8UC1, cv::Scalar(60));
    halves.colRange(16, 32) = 200;
    const Bytes bytes = encode(".jpg", halves);
    const MaskImage mask = decode_mask(bytes, *read_image_header(bytes));
    CHECK(mask(4, 8) == 0);
    CHECK(mask(28, 8) == 255);
}

TEST_CASE("Image I/O: palette images keep their colours, and a palette's transparency is a mask") {
    // 2x1 pixels, palette {(255,0,0), (0,0,255)}, one bit a pixel, tRNS {255, 0}; made with zlib and CRCs by hand.
    const Bytes png = {0x89, 0x50, 0x4E, 0x47, 0x0D, 0x0A, 0x1A, 0x0A, 0x00, 0x00, 0x00, 0x0D, 0x49, 0x48, 0x44,
                       0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01, 0x01, 0x03, 0x00, 0x00, 0x00, 0xCE,
                       0xEC, 0xED, 0xC9, 0x00, 0x00, 0x00, 0x06, 0x50, 0x4C, 0x54, 0x45, 0xFF, 0x00, 0x00, 0x00,
                       0x00, 0xFF, 0x6C, 0xA1, 0xFD, 0x8E, 0x00, 0x00, 0x00, 0x02, 0x74, 0x52, 0x4E, 0x53, 0xFF,
                       0x00, 0xE5, 0xB7, 0x30, 0x4A, 0x00, 0x00, 0x00, 0x0A, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9C,
                       0x63, 0x70, 0x00, 0x00, 0x00, 0x42, 0x00, 0x41, 0x29, 0x37, 0xF4, 0xEF, 0x00, 0x00, 0x00,
                       0x00, 0x49, 0x45, 0x4E, 0x44, 0xAE, 0x42, 0x60, 0x82};
    const auto header = read_image_header(png);
    REQUIRE(header);
    const CutOut cut_out = decode_cut_out(png, *header);
    CHECK(cut_out.image.pixels == std::vector<Rgb8>{{255, 0, 0}, {0, 0, 255}});
    REQUIRE(cut_out.mask);
    CHECK(cut_out.mask->pixels == std::vector<std::uint8_t>{255, 0});
    CHECK(decode_colour(png, *header).pixels == cut_out.image.pixels);
}

TEST_CASE("Image I/O: no PNG of another size than its header says comes back") {
    const Bytes png = encode(".png", waves(8, 8, CV_8UC3));
    ImageHeader lie = *read_image_header(png);
    lie.width = 9;
    CHECK_THROWS_AS(decode_colour(png, lie), InputError);
}
