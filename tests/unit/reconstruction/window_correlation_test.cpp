#include "core/reconstruction/window_correlation.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

using namespace anyrate;

namespace {

BrightnessImage speckles(int width, int height, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> brightness(100, 900);
    BrightnessImage image(width, height);
    for (std::uint16_t& pixel : image.pixels) pixel = static_cast<std::uint16_t>(brightness(random));
    return image;
}

BrightnessImage shifted(const BrightnessImage& image, int dx, int dy) {
    BrightnessImage moved(image.width, image.height, unknown_brightness);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (moved.contains(x + dx, y + dy)) moved(x + dx, y + dy) = image(x, y);
    return moved;
}

// A pixel moves by (dx, dy) times the inverse depth.
Parallax parallax(double dx, double dy) { return {Mat3::Identity(), Vec3(dx, dy, 0)}; }

std::vector<float> correlate(const BrightnessImage& a, const BrightnessImage& b, const Parallax& motion,
                             double inverse_depth, const PixelBox& box, int radius) {
    std::vector<float> correlations;
    WindowCorrelation(a, radius).correlate(PatchImage(b), motion, inverse_depth, box, correlations);
    return correlations;
}

// Straight from the definition; 0 where less than half of the window or not its middle is known.
double defined_correlation(const BrightnessImage& a, const BrightnessImage& b, int x, int y, int radius) {
    const auto known = [&](int u, int v) {
        return a.contains(u, v) && u + 1 < b.width && v + 1 < b.height && a(u, v) != unknown_brightness &&
               b(u, v) != unknown_brightness && b(u + 1, v) != unknown_brightness &&
               b(u, v + 1) != unknown_brightness && b(u + 1, v + 1) != unknown_brightness;
    };
    double n = 0, sum_a = 0, sum_b = 0;
    std::vector<std::pair<double, double>> pairs;
    for (int v = y - radius; v <= y + radius; ++v)
        for (int u = x - radius; u <= x + radius; ++u)
            if (known(u, v)) {
                pairs.emplace_back(a(u, v) / 510.0 - 1, b(u, v) / 510.0 - 1);
                sum_a += pairs.back().first;
                sum_b += pairs.back().second;
                ++n;
            }
    if (!known(x, y) || 2 * n < (2 * radius + 1) * (2 * radius + 1)) return 0;
    double aa = 0, bb = 0, ab = 0;
    for (const auto& [p, q] : pairs) {
        aa += (p - sum_a / n) * (p - sum_a / n) / n;
        bb += (q - sum_b / n) * (q - sum_b / n) / n;
        ab += (p - sum_a / n) * (q - sum_b / n) / n;
    }
    const double noise = 1.5 / 127.5;
    return ab > 0 ? ab * ab / ((aa + noise * noise) * (bb + noise * noise)) : 0;
}

}  // namespace

TEST_CASE("Window correlation: a view agrees with itself moved, on the plane that moves it back, and on no other") {
    const BrightnessImage image = speckles(48, 40, 1), moved = shifted(image, 5, -3);
    const PixelBox box{8, 8, 35, 30};  // no whole number of lanes wide
    const int pitch = WindowCorrelation::pitch_of(box);
    const auto right = correlate(image, moved, parallax(10, -6), 0.5, box, 1),
               wrong = correlate(image, moved, parallax(10, -6), 0.8, box, 1);
    double mean_wrong = 0;
    for (int y = 0; y < box.height(); ++y)
        for (int x = 0; x < box.width(); ++x) {
            CHECK(right[static_cast<std::size_t>(y * pitch + x)] > 0.99F);
            mean_wrong += wrong[static_cast<std::size_t>(y * pitch + x)] / (box.width() * box.height());
        }
    CHECK(mean_wrong < 0.3);
}

TEST_CASE("Window correlation: every window is as defined, at borders and around what is not known, too") {
    BrightnessImage a = speckles(30, 20, 2), b = a;
    const BrightnessImage other = speckles(30, 20, 3);
    for (std::size_t i = 0; i < b.pixels.size(); ++i)
        b.pixels[i] = static_cast<std::uint16_t>((b.pixels[i] + other.pixels[i]) / 2);
    for (int x = 3; x < 12; ++x) a(x, 4) = a(x, 9) = unknown_brightness;
    for (int y = 5; y < 15; ++y) b(20, y) = unknown_brightness;
    for (const int radius : {1, 2}) {
        const PixelBox box{0, 0, 30, 20};
        const auto found = correlate(a, b, parallax(0, 0), 1, box, radius);
        for (int y = 0; y < 20; ++y)
            for (int x = 0; x < 30; ++x)
                CHECK(static_cast<double>(found[static_cast<std::size_t>(y * WindowCorrelation::pitch_of(box) + x)]) ==
                      doctest::Approx(defined_correlation(a, b, x, y, radius)).epsilon(1e-3));
    }
}

TEST_CASE("Window correlation: light and contrast do not matter") {
    const BrightnessImage image = speckles(24, 24, 4);
    BrightnessImage darker = image;
    for (std::uint16_t& pixel : darker.pixels) pixel = static_cast<std::uint16_t>(pixel / 2 + 20);
    const PixelBox box{4, 4, 20, 20};
    for (const float correlation : correlate(image, darker, parallax(0, 0), 1, box, 1)) CHECK(correlation > 0.98F);
}
