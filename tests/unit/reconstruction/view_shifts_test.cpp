#include "core/reconstruction/view_shifts.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

constexpr int n_views = 12;

/// A different one for every view, of half a pixel.
Vec2 shift_of(std::size_t view) {
    const double angle = 2.4 * static_cast<double>(view);
    return 0.5 * Vec2(std::cos(angle), std::sin(angle));
}

Capture sphere() { return painted_sphere(n_views, 160, wavy_paint); }

/// Every camera claims that what it shows stands shift_of() pixels further back.
Capture with_wrong_cameras() {
    Capture capture = sphere();
    for (std::size_t i = 0; i < capture.views.size(); ++i) capture.views[i].camera.K.col(2).head<2>() -= shift_of(i);
    return capture;
}

}  // namespace

TEST_CASE("View shifts: true cameras have none") {
    const PhotoImages images = make_photo_images(sphere(), 3);
    for (const int level : {0, 1})
        for (const Vec2& shift : estimate_shifts(images, icosphere(4), level)) CHECK(shift.norm() < 0.03);
}

TEST_CASE("View shifts: what is wrong with the principal points is found and mended") {
    PhotoImages images = make_photo_images(with_wrong_cameras(), 3);
    const Mesh surface = icosphere(4);
    const std::vector<Vec2> shifts = estimate_shifts(images, surface, 0);
    REQUIRE(shifts.size() == n_views);
    for (std::size_t i = 0; i < shifts.size(); ++i) CHECK((shifts[i] - shift_of(i)).norm() < 0.1);

    shift_views(images, shifts);
    shift_views(images, estimate_shifts(images, surface, 0));
    const PhotoImages mended = make_photo_images(sphere(), 3);
    const Vec3 point(0.3, -0.2, 0.9);
    for (std::size_t i = 0; i < n_views; ++i)
        for (std::size_t level = 0; level < 3; ++level) {
            const Vec2 is = (images.views[i].levels[level].P * point.homogeneous()).hnormalized();
            const Vec2 should = (mended.views[i].levels[level].P * point.homogeneous()).hnormalized();
            CHECK((is - should).norm() < 0.05);
        }
}

TEST_CASE("View shifts: a view that shares nothing with others, and images without texture, have none") {
    Capture capture = with_wrong_cameras();
    capture.views.resize(2);  // each point is seen by one other view at most
    for (const Vec2& shift : estimate_shifts(make_photo_images(capture, 1), icosphere(4), 0))
        CHECK(shift == Vec2(0, 0));
    const Capture plain = painted_sphere(n_views, 160, [](const Vec3&) { return Vec3(100, 100, 100); });
    for (const Vec2& shift : estimate_shifts(make_photo_images(plain, 1), icosphere(4), 0)) CHECK(shift == Vec2(0, 0));
}

TEST_CASE("View shifts: what a translation does is taken out, and no more can be") {
    PhotoImages images = make_photo_images(sphere(), 1);
    const auto seen_at = [&](const Vec3& point) {
        std::vector<Vec2> pixels;
        for (const PhotoView& view : images.views)
            pixels.push_back((view.levels[0].P * point.homogeneous()).hnormalized());
        return pixels;
    };
    const auto moved_by = [&](const Vec3& step, const Vec3& from) {
        std::vector<Vec2> shifts = seen_at(from + step);
        const std::vector<Vec2> before = seen_at(from);
        for (std::size_t i = 0; i < shifts.size(); ++i) shifts[i] -= before[i];
        return shifts;
    };
    const Vec3 middle(0.1, -0.05, 0.02), step(2e-4, -1e-4, 3e-4);

    SUBCASE("shifts that a translation explains are the translation") {
        std::vector<Vec2> shifts = moved_by(step, middle);
        CHECK((take_translation(images, middle, shifts) - step).norm() < 1e-3 * step.norm());
        for (const Vec2& rest : shifts) CHECK(rest.norm() < 1e-4);
    }
    SUBCASE("what is left has no part of a translation, and both together are what was there") {
        std::vector<Vec2> shifts, rest;
        for (std::size_t i = 0; i < n_views; ++i) shifts.push_back(1e-3 * shift_of(i));
        rest = shifts;
        const Vec3 translation = take_translation(images, middle, rest);
        CHECK(translation.norm() > 0);
        const std::vector<Vec2> explained = moved_by(translation, middle);
        for (std::size_t i = 0; i < n_views; ++i) CHECK((explained[i] + rest[i] - shifts[i]).norm() < 1e-6);
        CHECK(take_translation(images, middle, rest).norm() < 1e-9 * translation.norm());
    }
    SUBCASE("a view without a shift has no say and gets none") {
        std::vector<Vec2> shifts = moved_by(step, middle);
        shifts[3] = Vec2(0, 0);
        CHECK((take_translation(images, middle, shifts) - step).norm() < 1e-3 * step.norm());
        CHECK(shifts[3] == Vec2(0, 0));
    }
    SUBCASE("one view alone does not say how far away things are") {
        images.views.resize(1);
        std::vector<Vec2> shifts{Vec2(0.5, 0.25)};
        const Vec3 translation = take_translation(images, middle, shifts);
        CHECK(shifts[0].norm() < 1e-9);
        CHECK(std::abs(translation.dot((images.views[0].centre - middle).normalized())) < 1e-9);
    }
}
