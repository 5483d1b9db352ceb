#include "core/capture/halve_view.h"

#include <doctest/doctest.h>

#include "core/capture/load_capture.h"
#include "tests/unit/capture/capture_on_disk.h"

using namespace anyrate;

TEST_CASE("Halved view: a point of the world is seen where two by two pixels have become one") {
    const View full = sphere_photographs().views[1];
    View half = full;
    halve(half);
    CHECK(half.camera.width == 24);
    CHECK(half.camera.height == 18);
    for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(1, -2, 3), Vec3(-4, 1, 2)}) {
        const Vec3 point = full.camera.centre() + full.camera.R.transpose() * (Vec3(0, 0, 20) + offset);
        // Pixel 0 covers what pixels 0 and 1 did: the edge at -0.5 stays, everything else is half as far from it.
        const Vec2 expected = 0.5 * (full.camera.project(point) + Vec2(0.5, 0.5)) - Vec2(0.5, 0.5);
        CHECK((half.camera.project(point) - expected).norm() < 1e-9);
    }
}

TEST_CASE(
    "Halved view: colours are means of four, the object where two of four are, and odd sizes lose their last pixels") {
    View view;
    view.image = ColourImage(5, 3);
    view.mask = MaskImage(5, 3);
    view.image(0, 0).r = 100, view.image(1, 0).r = 101, view.image(0, 1).r = 110, view.image(1, 1).r = 111;
    view.image(4, 0).g = view.image(0, 2).g = 255;
    view.mask(0, 0) = 1;
    view.mask(2, 0) = view.mask(3, 1) = 255;
    halve(view);
    REQUIRE(view.image.width == 2);
    REQUIRE(view.image.height == 1);
    CHECK(view.image.pixels == std::vector<Rgb8>{{106, 0, 0}, {0, 0, 0}});
    CHECK(view.mask.pixels == std::vector<std::uint8_t>{0, 255});
}

TEST_CASE("Capture: photographs that are too large together are halved until they are not") {
    const Capture photographs = sphere_photographs();  // six of 48x36
    const CaptureOnDisk disk(photographs);
    const auto loaded = [&](std::int64_t max_kept_pixels) {
        LoadOptions options;
        options.max_kept_pixels = max_kept_pixels;
        return load_capture(disk.path(), options);
    };
    CHECK(loaded(6 * 48 * 36).n_halvings == 0);
    CHECK(loaded(6 * 48 * 36).views[0].image.width == 48);
    const Capture once = loaded(6 * 48 * 36 - 1);
    CHECK(once.n_halvings == 1);
    View expected = photographs.views[2];
    halve(expected);
    CHECK(once.views[2].image.pixels == expected.image.pixels);
    CHECK(once.views[2].mask.pixels == expected.mask.pixels);
    CHECK(once.views[2].camera.K.isApprox(expected.camera.K, 1e-12));
    // A photograph of few pixels keeps them, whatever is asked.
    const Capture often = loaded(1);
    CHECK(often.views[0].image.width == 24);
    CHECK(often.views[0].image.height == 18);
}
