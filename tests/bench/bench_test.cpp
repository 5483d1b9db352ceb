#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/simulation/render.h"
#include "tests/bench/image_window.h"
#include "tests/bench/perturbations.h"
#include "tests/bench/silhouette_overlap.h"
#include "tests/scenes.h"

using namespace anyrate;

namespace {

const Vec3 some_point(0.3, -0.2, 0.5);

int n_object(const MaskImage& mask) {
    return static_cast<int>(std::count_if(mask.pixels.begin(), mask.pixels.end(), [](auto m) { return m != 0; }));
}

}  // namespace

TEST_CASE("move_world: a moved point is seen where it was, in every view") {
    const Capture before = sphere_capture(4, 64);
    for (const double scale : {1e-3, 1.0, 1e3}) {
        Capture capture = before;
        const Vec3 origin(1e4, -2e4, 5e3);
        bench::move_world(capture, scale, origin);
        Mesh mesh{.vertices = {some_point}, .triangles = {}, .colours = {}};
        bench::move_world(mesh, scale, origin);
        for (std::size_t i = 0; i < before.views.size(); ++i) {
            const Vec2 there = capture.views[i].camera.project(mesh.vertices[0]);
            CHECK((there - before.views[i].camera.project(some_point)).norm() < 1e-6);
        }
    }
}

TEST_CASE("look_through: the whole image at its own size has the same camera and mask") {
    const View view = sphere_capture(3, 64).views[0];
    const bench::Window whole{-0.5, -0.5, double(view.image.width), double(view.image.height)};
    const View same = bench::look_through(view, whole, view.image.width, view.image.height);
    CHECK((same.camera.K - view.camera.K).norm() < 1e-9);
    CHECK(same.mask.pixels == view.mask.pixels);
}

TEST_CASE("look_through: camera and pixels move together, so the silhouette still fits the mask") {
    const View view = sphere_capture(3, 240).views[1];
    const Mesh sphere = icosphere(5);
    for (const double factor : {0.5, 0.75, 1.5}) {
        const bench::Window window{20.5, 10.5, view.image.width - 31.0, view.image.height - 22.0};
        const View part = bench::look_through(view, window, static_cast<int>(factor * window.width),
                                              static_cast<int>(factor * window.height));
        CHECK(bench::silhouette_overlap(sphere, part) > 0.98);
    }
}

TEST_CASE("window_of_object: holds every pixel of the object, and touches it without a margin") {
    MaskImage mask(30, 20);
    mask(4, 7) = mask(11, 15) = 255;
    const bench::Window tight = bench::window_of_object(mask, 0);
    CHECK(tight.x == 3.5);
    CHECK(tight.y == 6.5);
    CHECK(tight.width == 8);
    CHECK(tight.height == 9);
    CHECK(bench::window_of_object(mask, 1.0).width == 8 + 2 * 9);
}

TEST_CASE("silhouette_overlap: the true surface fills its masks, a smaller one by the square of its size") {
    const View view = sphere_capture(3, 200).views[0];
    CHECK(bench::silhouette_overlap(icosphere(5), view) > 0.99);
    CHECK(bench::silhouette_overlap(icosphere(5, 0.8), view) == doctest::Approx(0.64).epsilon(0.03));
}

TEST_CASE("grow_masks: growing and shrinking move the outline of a disc by the radius") {
    Capture capture;
    View& view = capture.views.emplace_back();
    view.mask = MaskImage(80, 80);
    for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 80; ++x) view.mask(x, y) = std::hypot(x - 40, y - 40) <= 20 ? 255 : 0;
    Capture grown = capture, shrunk = capture;
    bench::grow_masks(grown, 2);
    bench::grow_masks(shrunk, -2);
    CHECK(n_object(grown.views[0].mask) == doctest::Approx(3.1416 * 22 * 22).epsilon(0.03));
    CHECK(n_object(shrunk.views[0].mask) == doctest::Approx(3.1416 * 18 * 18).epsilon(0.03));
}

TEST_CASE("disturb_poses: what is seen in the middle moves by the distance asked for, the cameras' centres stay") {
    const Capture before = sphere_capture(5, 160);
    Capture after = before;
    bench::disturb_poses(after, 0.5, 7);
    for (std::size_t i = 0; i < before.views.size(); ++i) {
        const Camera &a = before.views[i].camera, &b = after.views[i].camera;
        CHECK((b.project(Vec3::Zero()) - a.project(Vec3::Zero())).norm() == doctest::Approx(0.5).epsilon(0.02));
        CHECK((b.centre() - a.centre()).norm() < 1e-9);
    }
}

TEST_CASE("change_gain: every view gets one factor within the range, views differ") {
    const Capture before = sphere_capture(6, 48);
    Capture after = before;
    bench::change_gain(after, 0.2, 3);
    std::vector<double> gains;
    for (std::size_t i = 0; i < before.views.size(); ++i) {
        double sum_before = 0, sum_after = 0;
        for (std::size_t p = 0; p < before.views[i].image.pixels.size(); ++p) {
            const int level = before.views[i].image.pixels[p].g;
            if (level < 60 || level > 200) continue;  // neither rounded away nor cut off at 255
            sum_before += level;
            sum_after += after.views[i].image.pixels[p].g;
        }
        gains.push_back(sum_after / sum_before);
    }
    const auto [least, most] = std::minmax_element(gains.begin(), gains.end());
    CHECK(*least > 0.79);
    CHECK(*most < 1.21);
    CHECK(*most - *least > 0.05);
}

TEST_CASE("keep_every, crop, resample: views and sizes are those asked for") {
    Capture capture = sphere_capture(11, 80);
    bench::keep_every(capture, 2);
    CHECK(capture.views.size() == 6);
    bench::resample(capture, 0.75, 2);
    CHECK(capture.views[0].image.width == 60);
    CHECK(capture.views[1].image.width == 80);
    bench::resample(capture, 0.5);
    CHECK(capture.views[0].image.width == 30);
    CHECK(capture.views[1].mask.height == 30);
    bench::crop(capture, 0.5, 1);
    CHECK(capture.views[0].image.width == 15);
    CHECK(capture.views[1].mask.height == 15);
    CHECK(capture.views[1].camera.width == 20);
}

TEST_CASE("crop: a point of the world has the same colour and mask as before, wherever it is still in the image") {
    const Capture whole = sphere_capture(4, 120);
    Capture capture = whole;
    bench::crop(capture, 0.7, 5);
    for (std::size_t i = 0; i < whole.views.size(); ++i) {
        const View &before = whole.views[i], &part = capture.views[i];
        const Mat3 moved = before.camera.K * part.camera.K.inverse();
        CHECK((part.camera.R - before.camera.R).norm() == 0);
        int n_different = 0;
        for (int y = 0; y < part.image.height; ++y)
            for (int x = 0; x < part.image.width; ++x) {
                const Vec2 there = (moved * Vec3(x, y, 1)).hnormalized();
                const int u = static_cast<int>(std::lround(there.x())), v = static_cast<int>(std::lround(there.y()));
                REQUIRE((there - Vec2(u, v)).norm() < 1e-6);
                const Rgb8 &now = part.image(x, y), &was = before.image(u, v);
                n_different +=
                    now.r != was.r || now.g != was.g || now.b != was.b || part.mask(x, y) != before.mask(u, v);
            }
        CHECK(n_different == 0);
    }
}

TEST_CASE("fade_texture: neighbouring pixels of a sphere differ by the part that is kept, and by noise") {
    const Capture photographs = sphere_capture(3, 160);
    const auto mean_difference = [&](double kept) {
        Capture capture = photographs;
        bench::fade_texture(capture, icosphere(5), kept, 1);
        const ColourImage& image = capture.views[0].image;
        double sum = 0;
        for (int y = image.height / 2 - 20; y < image.height / 2 + 20; ++y)
            for (int x = image.width / 2 - 20; x < image.width / 2 + 20; ++x)
                sum += std::abs(image(x, y).g - image(x + 1, y).g);
        return sum / (40 * 40);
    };
    const double textured = mean_difference(1);
    REQUIRE(textured > 8);
    CHECK(mean_difference(0.5) == doctest::Approx(0.5 * textured).epsilon(0.2));
    CHECK(mean_difference(0) < 2);  // of two levels with noise of one: 1.1, and the shading's slope
}
