#include "core/mesh/compare.h"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "core/error.h"
#include "core/mesh/surface_samples.h"
#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

TEST_CASE("sample_surface: points are uniform by area") {
    // On the unit sphere the mean of z^2 is 1/3 and half of the points have |z| below 1/2 (Archimedes).
    const std::vector<Vec3> points = sample_surface(icosphere(4), 40'000, 7).points;
    double z2 = 0, low = 0;
    for (const Vec3& p : points) {
        z2 += p.z() * p.z() / 40'000;
        low += std::abs(p.z()) < 0.5 ? 1.0 / 40'000 : 0.0;
    }
    CHECK(z2 == doctest::Approx(1.0 / 3).epsilon(0.02));
    CHECK(low == doctest::Approx(0.5).epsilon(0.02));
}

TEST_CASE("compare: two concentric spheres are their radii's difference apart, at every point") {
    const SurfaceDistance d = compare_surfaces(icosphere(5, 1.1), icosphere(5), {.n_samples = 5000});
    const double expected = 0.1 / (2 * std::sqrt(3.0));  // the box of the unit sphere has the diagonal 2 sqrt(3)
    CHECK(d.accuracy == doctest::Approx(expected).epsilon(0.01));
    CHECK(d.completeness == doctest::Approx(expected).epsilon(0.01));
    CHECK(d.mean == doctest::Approx(expected).epsilon(0.01));
    CHECK(d.p90 == doctest::Approx(expected).epsilon(0.01));
    CHECK(d.hausdorff == doctest::Approx(expected).epsilon(0.02));
}

TEST_CASE("compare: a mesh is no distance from itself, and the scale does not matter") {
    const Mesh shape = shapes::zero_set([](const Vec3& p) { return p.norm() - 0.8; }, 10);
    CHECK(compare_surfaces(shape, shape, {.n_samples = 1000}).hausdorff < 1e-12);
    Mesh moved = shapes::translated(shape, {0.01, 0, 0});
    const double small = compare_surfaces(moved, shape, {.n_samples = 1000}).mean;
    Mesh large = shape;
    for (Mesh* mesh : {&large, &moved})
        for (Vec3& v : mesh->vertices) v *= 1000;
    CHECK(compare_surfaces(moved, large, {.n_samples = 1000}).mean == doctest::Approx(small));
}

TEST_CASE("compare: a cube moved along x by t is t/3 away on average, and at most t") {
    // Of six faces the two across x are t away (within the small rest of their rims), the others slide in themselves.
    Mesh cube;
    for (int i = 0; i < 8; ++i) cube.vertices.emplace_back(i & 1, i >> 1 & 1, i >> 2);
    cube.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    const double t = 0.01, diagonal = std::sqrt(3.0);
    const SurfaceDistance d = compare_surfaces(shapes::translated(cube, {t, 0, 0}), cube, {.n_samples = 40'000});
    CHECK(d.mean * diagonal == doctest::Approx(t / 3).epsilon(0.05));
    CHECK(d.hausdorff * diagonal == doctest::Approx(t));
}

TEST_CASE("compare: accuracy sees what is too much, completeness what is missing") {
    const Mesh one = icosphere(3), two = shapes::together(one, shapes::translated(one, {4, 0, 0}));
    const SurfaceDistance missing = compare_surfaces(one, two, {.n_samples = 2000});
    CHECK(missing.accuracy < 1e-12);
    CHECK(missing.completeness > 0.1);
    const SurfaceDistance extra = compare_surfaces(two, one, {.n_samples = 2000});
    CHECK(extra.completeness < 1e-12);
    CHECK(extra.accuracy > 0.1);
}

TEST_CASE("compare: only what is seen is compared") {
    const Mesh one = icosphere(3), two = shapes::together(one, shapes::translated(one, {4, 0, 0}));
    const auto left_one_is_seen = [](const Vec3& p) { return p.x() < 1.5; };
    CHECK(compare_surfaces(one, two, left_one_is_seen, {.n_samples = 2000}).hausdorff < 1e-12);
    CHECK_THROWS_AS(compare_surfaces(one, two, [](const Vec3&) { return false; }), InputError);
}

TEST_CASE("compare: one thread and many give the same numbers") {
    const Mesh a = icosphere(3, 1.05), b = icosphere(4);
    const SurfaceDistance many = compare_surfaces(a, b, {.n_samples = 3000});
    const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
    const SurfaceDistance one = compare_surfaces(a, b, {.n_samples = 3000});
    CHECK(one.accuracy == many.accuracy);
    CHECK(one.completeness == many.completeness);
    CHECK(one.p90 == many.p90);
}

TEST_CASE("compare: a surface without area is refused") {
    CHECK_THROWS_AS(compare_surfaces(Mesh{}, icosphere(1)), InputError);
    CHECK_THROWS_AS(compare_surfaces(icosphere(1), Mesh{}), InputError);
}
