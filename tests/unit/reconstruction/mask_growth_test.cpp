#include "core/reconstruction/mask_growth.h"

#include <doctest/doctest.h>

#include <cmath>
#include <optional>

#include "core/reconstruction/reconstruct.h"
#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"
#include "move_masks.h"

using namespace anyrate;

namespace {

constexpr double reach_px = 8;

Capture sphere() { return painted_sphere(12, 160, wavy_paint); }

/// With masks whose borders are moved outwards.
Capture with_grown_masks(double px) {
    Capture capture = sphere();
    move_masks(capture, px);
    return capture;
}

double growth_of(const Capture& capture, const Mesh& surface) {
    Silhouettes silhouettes(capture);
    return estimate_mask_growth(silhouettes, surface, reach_px);
}

class LastState final : public ModelSink {
public:
    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override {
        in_world = grid;
        state.emplace(base, grid, rules);
        return base;
    }
    void base_attributes(std::span<const Rgb8>, const DistortionPoint&) override {}
    void batch(std::span<const SplitRecord>, const RefinableMesh& now, std::span<const Rgb8>,
               const DistortionPoint&) override {
        state = now;
    }
    void finish() override {}

    Grid in_world;
    std::optional<RefinableMesh> state;
};

/// Of a reconstruction's vertices around the origin, world units.
double mean_radius(const Capture& capture) {
    LastState sink;
    reconstruct(capture, {.n_vertices = 600, .n_coarse = 100}, sink, {}, {}, nullptr);
    sink.state->move_grid(sink.in_world.origin, sink.in_world.unit);
    const Mesh mesh = sink.state->to_mesh();
    double sum = 0;
    for (const Vec3& v : mesh.vertices) sum += v.norm();
    return sum / mesh.n_vertices();
}

}  // namespace

TEST_CASE("Mask growth: masks around the true surface are right") {
    for (const int subdivisions : {3, 4, 5}) CHECK(std::abs(growth_of(sphere(), icosphere(subdivisions))) < 0.3);
}

TEST_CASE("Mask growth: masks that are too small or too large are found out, and mended") {
    const Mesh surface = icosphere(4);
    for (const double px : {-3.0, -1.0, 1.0, 3.0}) {
        Silhouettes silhouettes(with_grown_masks(px));
        const double growth = estimate_mask_growth(silhouettes, surface, reach_px);
        CHECK(growth == doctest::Approx(-px).epsilon(0.3));
        silhouettes.grow_masks(growth);
        CHECK(std::abs(estimate_mask_growth(silhouettes, surface, reach_px)) < 0.15);
        silhouettes.grow_masks(0);
        CHECK(estimate_mask_growth(silhouettes, surface, reach_px) == growth);
    }
}

TEST_CASE("Mask growth: what no contour tells is 0") {
    CHECK(growth_of(sphere(), icosphere(0)) == 0);       // too few vertices
    CHECK(growth_of(sphere(), icosphere(4, 0.5)) == 0);  // none within reach
}

TEST_CASE("Mask growth: a surface neither shrinks nor swells with its masks") {
    const View view = sphere().views[0];
    const double pixel = view.camera.centre().norm() / view.camera.K(0, 0), radius = mean_radius(sphere());
    for (const double px : {-2.0, 2.0}) CHECK(std::abs(mean_radius(with_grown_masks(px)) - radius) < 0.15 * pixel);
}
