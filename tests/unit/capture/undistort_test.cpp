#include "core/capture/undistort.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/capture/load_capture.h"
#include "tests/unit/capture/capture_on_disk.h"

using namespace anyrate;

namespace {

Camera small_camera(int width, int height) {
    Camera camera;
    camera.K << 80, 0.5, width / 2.0, 0, 75, height / 2.0, 0, 0, 1;
    camera.width = width;
    camera.height = height;
    return camera;
}

/// A smooth picture over the plane at depth 1, and a disk in it.
Rgb8 painted(const Vec2& at) {
    const auto level = [](double v) { return static_cast<std::uint8_t>(std::lround(128 + 90 * std::sin(v))); };
    return {level(6 * at.x()), level(6 * at.y()), level(4 * (at.x() + at.y()))};
}
bool in_disk(const Vec2& at) { return at.norm() < 0.3; }

/// The point of the ideal picture that a distorted one shows at `seen`: fixed-point iteration.
Vec2 inverse(const Distortion& lens, const Vec2& seen) {
    Vec2 point = seen;
    for (int i = 0; i < 100; ++i) point += seen - lens.distort(point);
    return point;
}

template <class IdealFromPixel>
View photograph(int width, int height, const IdealFromPixel& ideal_from_pixel) {
    View view{"", small_camera(width, height), ColourImage(width, height), MaskImage(width, height)};
    const Mat3 K_inverse = view.camera.K.inverse();
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const Vec2 at = ideal_from_pixel(Vec2((K_inverse * Vec3(x, y, 1)).head<2>()));
            view.image(x, y) = painted(at);
            view.mask(x, y) = in_disk(at) ? 255 : 0;
        }
    }
    return view;
}

}  // namespace

TEST_CASE("Undistort: a photograph through the lens becomes one through an ideal lens") {
    const Distortion lens{-0.2, 0.05, 0.003, -0.002, 0.01};
    View view = photograph(80, 60, [&](const Vec2& seen) { return inverse(lens, seen); });
    const View ideal = photograph(80, 60, [](const Vec2& at) { return at; });
    undistort(view, lens);
    const Mat3 K_inverse = view.camera.K.inverse();
    int worst = 0;
    for (std::size_t i = 0; i < ideal.image.pixels.size(); ++i) {
        const Vec2 at = (K_inverse * Vec3(static_cast<double>(i % 80), static_cast<double>(i / 80), 1)).head<2>();
        const double edge_distance_px = 80 * std::abs(at.norm() - 0.3);
        if (view.mask.pixels[i] != ideal.mask.pixels[i]) CHECK(edge_distance_px < 1.0);
        const Rgb8 is = view.image.pixels[i], should = ideal.image.pixels[i];
        if (is == Rgb8{}) continue;  // outside the photograph
        worst = std::max({worst, std::abs(is.r - should.r), std::abs(is.g - should.g), std::abs(is.b - should.b)});
    }
    CHECK(worst <= 3);
}

TEST_CASE("Undistort: what the photograph does not show is background") {
    View view = photograph(80, 60, [](const Vec2& at) { return at; });
    view.mask = MaskImage(80, 60, 255);
    undistort(view, {.k1 = 1.0});  // pincushion: the corners lie outside the photograph
    CHECK(view.mask(0, 0) == 0);
    CHECK(view.image(0, 0) == Rgb8{});
    CHECK(view.mask(40, 30) == 255);
}

TEST_CASE("Undistort: beyond the radius where the polynomial turns back there is nothing") {
    View view = photograph(80, 60, [](const Vec2& at) { return at; });
    view.mask = MaskImage(80, 60, 255);
    undistort(view, {.k1 = -2.0});  // turns back at r^2 = 1/6, r = 0.41, at 32 pixels
    CHECK(view.mask(40 + 31, 30) == 255);
    CHECK(view.mask(40 + 34, 30) == 0);
}

TEST_CASE("Undistort: load_capture applies the distortion of an entry, K stays") {
    const CaptureOnDisk disk;
    disk.change_entry(0, [](nlohmann::json& entry) { entry["distortion"] = {-0.1, 0.0, 0.0, 0.0}; });
    const Capture plain = sphere_photographs(), loaded = load_capture(disk.path());
    View expected = plain.views[0];
    undistort(expected, {.k1 = -0.1});
    CHECK(loaded.views[0].image.pixels == expected.image.pixels);
    CHECK(loaded.views[0].mask.pixels == expected.mask.pixels);
    CHECK(loaded.views[0].image.pixels != plain.views[0].image.pixels);
    CHECK((loaded.views[0].camera.K - plain.views[0].camera.K).norm() < 1e-12);
    CHECK(loaded.views[1].image.pixels == plain.views[1].image.pixels);
}
