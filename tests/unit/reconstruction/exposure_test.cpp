#include "core/reconstruction/exposure.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

constexpr int n_views = 12;

// Red and blue of view i; green has the exposure 1.
double red_exposure(int i) { return 1 + 0.2 * std::sin(2.1 * i); }
double blue_exposure(int i) { return 1 - 0.1 * std::cos(1.3 * i); }

Capture unevenly_exposed() {
    Capture capture = painted_sphere(n_views, 160, wavy_paint);
    for (int i = 0; i < n_views; ++i)
        for (Rgb8& c : capture.views[static_cast<std::size_t>(i)].image.pixels) {
            const auto scaled = [](std::uint8_t value, double exposure) {
                return static_cast<std::uint8_t>(std::min(std::lround(value * exposure), 255l));
            };
            c.r = scaled(c.r, red_exposure(i));
            c.b = scaled(c.b, blue_exposure(i));
        }
    return capture;
}

double geometric_mean(double (*exposure)(int)) {
    double sum = 0;
    for (int i = 0; i < n_views; ++i) sum += std::log(exposure(i));
    return std::exp(sum / n_views);
}

}  // namespace

TEST_CASE("Exposure: the gains of all views and channels are found on a surface that is off by a pixel") {
    const auto gains = estimate_gains(make_photo_images(unevenly_exposed(), 3), icosphere(4, 0.99));
    REQUIRE(gains.size() == n_views);
    for (int i = 0; i < n_views; ++i) {
        const Gains& gain = gains[static_cast<std::size_t>(i)];
        CHECK(gain[0] == doctest::Approx(red_exposure(i) / geometric_mean(red_exposure)).epsilon(0.01));
        CHECK(gain[1] == doctest::Approx(1).epsilon(0.01));
        CHECK(gain[2] == doctest::Approx(blue_exposure(i) / geometric_mean(blue_exposure)).epsilon(0.01));
    }
}

TEST_CASE("Exposure: what was evened out is even, and then stays as it is") {
    PhotoImages images = make_photo_images(unevenly_exposed(), 3);
    const Mesh sphere = icosphere(4);
    even_out_exposure(images, sphere);
    for (const Gains& gain : estimate_gains(images, sphere))
        for (const double g : gain) CHECK(g == doctest::Approx(1).epsilon(0.01));
    const auto once = images.views[3].levels[0].rgba;
    even_out_exposure(images, sphere);
    CHECK(images.views[3].levels[0].rgba == once);
}

TEST_CASE("Exposure: a view that shares nothing with others keeps its colours") {
    Capture capture = painted_sphere(n_views, 160, wavy_paint);
    for (std::uint8_t& pixel : capture.views[2].mask.pixels) pixel = 0;
    const auto gains = estimate_gains(make_photo_images(capture, 3), icosphere(4));
    CHECK(gains[2][0] == doctest::Approx(1).epsilon(0.01));
}
