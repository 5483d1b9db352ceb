#include "core/reconstruction/silhouette_term.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

constexpr double reach_px = 3;

std::vector<std::int32_t> all_vertices(const Mesh& mesh) {
    std::vector<std::int32_t> all(mesh.vertices.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
}

std::vector<SilhouetteTerm> terms_of(const Capture& capture, const Mesh& mesh) {
    Silhouettes silhouettes(capture);
    silhouettes.look(mesh);
    const OneRings rings(mesh);
    return silhouettes.terms(mesh, rings, vertex_normals(mesh, rings), all_vertices(mesh), reach_px);
}

/// Bilinear, pixels; as the silhouettes have it, far from the border no more than a bound.
double distance_at(const Image<std::int8_t>& image, const Vec2& pixel) {
    const int x = static_cast<int>(pixel.x()), y = static_cast<int>(pixel.y());
    const double u = pixel.x() - x, v = pixel.y() - y;
    return ((1 - v) * ((1 - u) * image(x, y) + u * image(x + 1, y)) +
            v * ((1 - u) * image(x, y + 1) + u * image(x + 1, y + 1))) /
           8;
}

}  // namespace

TEST_CASE("Silhouettes: what stands out of a mask is pulled by its squared distance to the border, view by view") {
    const Capture capture = painted_sphere(5, 128, wavy_paint);
    const Mesh mesh = icosphere(3, 1.1);  // around the unit sphere: its whole rim stands out
    const std::vector<SilhouetteTerm> terms = terms_of(capture, mesh);
    std::vector<double> expected(mesh.vertices.size(), 0.0);
    for (const View& view : capture.views) {
        const Image<std::int8_t> distance = silhouette_distance(view.mask);
        for (std::size_t v = 0; v < expected.size(); ++v) {
            const double d = distance_at(distance, (view.camera.P() * mesh.vertices[v].homogeneous()).hnormalized());
            if (d < 0) expected[v] += d * d;
        }
    }
    for (std::size_t v = 0; v < expected.size(); ++v) CHECK(terms[v].energy == doctest::Approx(expected[v]));
    CHECK(std::ranges::count_if(expected, [](double e) { return e > 0; }) > 100);
    CHECK(std::ranges::count(expected, 0.0) > 20);
}

TEST_CASE("Silhouettes: a rim within reach of the border is pulled out to it, one further in is not") {
    const Capture capture = painted_sphere(5, 128, wavy_paint);
    const double pixel = capture.views[0].camera.centre().norm() / capture.views[0].camera.K(0, 0);
    const auto sum_within = [&](double px) {
        double sum = 0;
        for (const SilhouetteTerm& term : terms_of(capture, icosphere(4, 1 - px * pixel))) sum += term.energy;
        return sum;
    };
    CHECK(sum_within(2) > 10 * sum_within(0));
    CHECK(sum_within(6) == 0);
}
