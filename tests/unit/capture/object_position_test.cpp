// Blunders of calibration that only the views together show.
#include "core/capture/object_position.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <utility>

#include "core/capture/check_camera.h"
#include "tests/unit/capture/capture_on_disk.h"

using namespace anyrate;

namespace {

std::string refusal_of(const Capture& capture) { return refusal(CaptureOnDisk(capture).path()); }

/// The same photographs in a world whose origin is the given point of the present one.
Capture with_origin(Capture capture, const Vec3& origin) {
    for (View& view : capture.views) view.camera.t += view.camera.R * origin;
    return capture;
}

const Vec3 sphere_centre(3, -2, 5);

}  // namespace

TEST_CASE("Object position: t turned over in one view is found, wherever the world's origin is") {
    for (const Vec3& origin : {Vec3(0, 0, 0), sphere_centre, Vec3(3, -2, 4.5), Vec3(100, -2000, 50)}) {
        for (std::size_t i = 0; i < 6; ++i) {
            Capture capture = with_origin(sphere_photographs(), origin);
            capture.views[i].camera.t *= -1.0;
            const std::string said = refusal_of(capture);
            INFO(said);
            CHECK(n_lines(said) == 1);
            CHECK(says(said, {capture.views[i].name, "expected"}));
        }
    }
}

TEST_CASE("Object position: t turned over in all views is found, wherever the world's origin is") {
    for (const Vec3& origin : {Vec3(0, 0, 0), sphere_centre, Vec3(100, -2000, 50)}) {
        Capture capture = with_origin(sphere_photographs(), origin);
        for (View& view : capture.views) view.camera.t *= -1.0;
        const std::string said = refusal_of(capture);
        INFO(said);
        CHECK(n_lines(said) == 1);
        CHECK(says(said, {"cameras.json: the object is behind all 6 cameras", "expected positive depth"}));
    }
}

TEST_CASE("Object position: camera-to-world poses are found") {
    Capture capture = sphere_photographs();
    for (View& view : capture.views) {
        const Vec3 centre = view.camera.centre();
        view.camera.R.transposeInPlace();
        view.camera.t = centre;
    }
    CHECK(says(refusal_of(capture), {"expected", "x ~ K (R X + t) from world to camera"}));
}

TEST_CASE("Object position: cameras that look along -z with y up are found") {
    Capture capture = sphere_photographs();
    const Mat3 half_turn = Vec3(1, -1, -1).asDiagonal();
    for (View& view : capture.views) {
        view.camera.R = half_turn * view.camera.R;
        view.camera.t = half_turn * view.camera.t;
    }
    CHECK(!refusal_of(capture).empty());
}

TEST_CASE("Object position: a mask that shows something else than the other views is found") {
    Capture capture = sphere_photographs();
    MaskImage& mask = capture.views[4].mask;
    mask = MaskImage(mask.width, mask.height);
    for (int y = 2; y < 8; ++y)
        for (int x = 2; x < 8; ++x) mask(x, y) = 255;
    const std::string said = refusal_of(capture);
    INFO(said);
    CHECK(n_lines(said) == 1);
    CHECK(says(said, {"images/004.png: its mask shows the object where", "expected"}));
}

TEST_CASE("Object position: an object cut off by the image's border in some views is no fault") {
    Capture capture = sphere_photographs();
    for (const std::size_t i : {1u, 4u}) {
        // Crop the right half away: the mask now touches the border, and its centroid has moved.
        View& view = capture.views[i];
        const int width = 26;
        ColourImage image(width, 36);
        MaskImage mask(width, 36);
        for (int y = 0; y < 36; ++y) {
            for (int x = 0; x < width; ++x) {
                image(x, y) = view.image(x, y);
                mask(x, y) = view.mask(x, y);
            }
        }
        view.image = std::move(image);
        view.mask = std::move(mask);
        view.camera.width = width;
    }
    CHECK(refusal_of(capture) == "");
}

TEST_CASE("Object position: specks far from the object in some masks are no fault") {
    Capture capture = sphere_photographs();
    capture.views[1].mask(1, 1) = 255;
    capture.views[3].mask(46, 34) = 255;
    CHECK(refusal_of(capture) == "");
}

TEST_CASE("Object position: cameras all at one place have no baseline") {
    Capture capture = sphere_photographs();
    const Vec3 centre = capture.views[0].camera.centre();
    for (View& view : capture.views) view.camera.t = -view.camera.R * centre;
    const std::string said = refusal_of(capture);
    CHECK(says(said, {"cameras.json: all 6 cameras stand at one place", "expected views from different places"}));
}
