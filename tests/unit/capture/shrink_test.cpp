#include "core/capture/shrink.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <cstdlib>

namespace anyrate {
namespace {

/// Red grows from left to right, green from top to bottom.
ColourImage ramp(int width, int height) {
    ColourImage image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            image(x, y) = {static_cast<std::uint8_t>(255 * x / width), static_cast<std::uint8_t>(255 * y / height), 7};
    return image;
}

}  // namespace

TEST_CASE("shrink: keeps the shape of an image, and one that is small enough as it is") {
    CHECK(shrink(ramp(640, 480), 160).width == 160);
    CHECK(shrink(ramp(640, 480), 160).height == 120);
    CHECK(shrink(ramp(480, 640), 160).width == 120);
    CHECK(shrink(ramp(1000, 2), 10).height == 1);
    CHECK(shrink(ramp(30, 20), 30).pixels == ramp(30, 20).pixels);
}

TEST_CASE("shrink: a pixel is the mean of the block that it stands for") {
    const ColourImage image = ramp(70, 50), small = shrink(image, 7);
    REQUIRE(small.height == 5);
    for (int y = 0; y < 5; ++y) {
        for (int x = 0; x < 7; ++x) {
            int red = 0;
            for (int dy = 0; dy < 10; ++dy)
                for (int dx = 0; dx < 10; ++dx) red += image(10 * x + dx, 10 * y + dy).r;
            CHECK(small(x, y).r == (red + 50) / 100);
        }
    }
}

TEST_CASE("shrink: a pattern becomes its mean, also where the sides do not divide") {
    ColourImage image(101, 67);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i].g = i % 2 ? 255 : 0;
    for (const Rgb8& pixel : shrink(image, 10).pixels) CHECK(std::abs(pixel.g - 127) < 4);
}

}  // namespace anyrate
