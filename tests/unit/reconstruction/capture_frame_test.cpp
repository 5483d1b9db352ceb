#include "core/reconstruction/capture_frame.h"

#include <doctest/doctest.h>

#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

/// The same cameras in a world whose unit is 1 / scale and whose origin stands at -shift.
Capture in_other_world(Capture capture, double scale, const Vec3& shift) {
    for (View& view : capture.views) view.camera.t = scale * view.camera.t - view.camera.R * shift;
    return capture;
}

}  // namespace

TEST_CASE("Capture frame: captures that differ in the world's unit and origin become the same, bit by bit") {
    Capture own = painted_sphere(9, 16, wavy_paint);
    const Capture original = own;
    to_own_frame(own);
    for (const auto& [scale, shift] :
         {std::pair(1e-3, Vec3(0, 0, 0)), std::pair(1e3, Vec3(2, -5, 11)), std::pair(0.7, Vec3(1e3, -2e3, 500))}) {
        Capture other = in_other_world(original, scale, shift);
        to_own_frame(other);
        for (std::size_t i = 0; i < own.views.size(); ++i) CHECK(own.views[i].camera.t == other.views[i].camera.t);
    }
}

TEST_CASE("Capture frame: points are seen where they were, and a grid stands where it stood") {
    const Capture world = in_other_world(painted_sphere(9, 16, wavy_paint), 30, Vec3(100, -200, 50));
    Capture own = world;
    const CaptureFrame frame = to_own_frame(own);
    double distance = 0;
    for (const View& view : own.views) distance += view.camera.centre().norm() / 9;
    CHECK(distance == doctest::Approx(1).epsilon(1e-6));

    const Grid grid{Vec3(-0.5, -0.25, -1), 1e-3, 14, 2};
    const Grid grid_in_world = frame.in_world(grid);
    CHECK(grid_in_world.bits == grid.bits);
    CHECK(grid_in_world.base_shift == grid.base_shift);
    const Vec3 steps(300, 20, 900);
    for (std::size_t i = 0; i < own.views.size(); ++i) {
        const Vec2 there = world.views[i].camera.project(grid_in_world.origin + grid_in_world.unit * steps);
        CHECK((own.views[i].camera.project(grid.origin + grid.unit * steps) - there).norm() < 1e-4);
    }
}
