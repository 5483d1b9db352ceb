#include "core/progressive/surface_approach.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mesh/edges.h"
#include "core/mesh/self_intersections.h"
#include "core/progressive/batch_selection.h"
#include "core/simulation/parametric_meshes.h"
#include "tests/grid_scenes.h"

using namespace anyrate;

namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

const TrueSurface& unit_sphere() {
    static const TrueSurface surface(icosphere(5), 60'000);
    return surface;
}

RefinableMesh sphere_on_grid(int level, double radius = 1.0) {
    return {on_grid(icosphere(level, radius), unit_grid), unit_grid, {}};
}

}  // namespace

TEST_CASE("Approach: concentric spheres are apart by the difference of their radii everywhere") {
    SurfaceMeter meter(unit_sphere());
    const MeasuredMesh now = measure(sphere_on_grid(4, 0.9), meter);
    // Half from the mesh, half from the surface: the mean of both areas.
    const double area = 2 * std::numbers::pi * (1 + 0.81);
    CHECK(squared_distance(now) == doctest::Approx(0.01 * area).epsilon(0.03));
    const std::vector<double> scores = distance_scores(now);
    double sum = 0;
    for (const double score : scores) sum += score;
    CHECK(sum == doctest::Approx(0.1 * 4 * std::numbers::pi * 0.81).epsilon(0.03));  // distance times the mesh's area
    CHECK(gain_of_a_bit(now) * now.mesh.n_vertices() * 13 == doctest::Approx(2 * squared_distance(now)));
}

TEST_CASE(
    "Approach: distances well above the surface's own noise count as they are, those within it by their squares") {
    const auto promised = [](double radius, double noise) {
        SurfaceMeter meter(unit_sphere());
        double sum = 0;
        for (const double score : distance_scores(measure(sphere_on_grid(4, radius), meter), noise)) sum += score;
        return sum / (4 * std::numbers::pi * radius * radius);
    };
    CHECK(promised(0.9, 0.001) == doctest::Approx(0.1).epsilon(0.04));
    CHECK(promised(0.95, 1.0) == doctest::Approx(0.05 * 0.05 / 2).epsilon(0.08));
    CHECK(promised(0.9, 1.0) / promised(0.95, 1.0) == doctest::Approx(4).epsilon(0.08));
}

TEST_CASE("Approach: a face promises its area times its distance, its neighbours nothing of it") {
    const Mesh sphere = icosphere(2);
    MeasuredMesh now{sphere, std::vector<FaceDistance>(320, FaceDistance{.area = 1})};
    const auto& [a, b, c] = sphere.triangles[50];
    const auto& v = sphere.vertices;
    now.faces[50].squared = 4;
    std::vector<double> expected(320, 0.0);
    expected[50] = 2 * 0.5 * (v[at(b)] - v[at(a)]).cross(v[at(c)] - v[at(a)]).norm();
    const std::vector<double> scores = distance_scores(now);
    for (std::size_t f = 0; f < scores.size(); ++f) CHECK(scores[f] == doctest::Approx(expected[f]));
}

TEST_CASE("Approach: what a few faces are off beyond the usual makes no bit dearer") {
    MeasuredMesh now{icosphere(2), std::vector<FaceDistance>(320, FaceDistance{.area = 2, .squared = 0.5})};
    const double usual = gain_of_a_bit(now);
    now.faces[7].squared = 10;  // twenty times as far as the others, squared
    CHECK(gain_of_a_bit(now) == doctest::Approx(usual * (319 + 20) / 320));
    now.faces[7].squared = 1e9;
    CHECK(gain_of_a_bit(now) == doctest::Approx(usual * (319 + 30) / 320));
    now.faces[7] = {};  // not measured
    CHECK(gain_of_a_bit(now) == doctest::Approx(usual * 319 / 320));
    std::ranges::fill(now.faces, FaceDistance{});
    CHECK(gain_of_a_bit(now) == 0);
}

TEST_CASE("Approach: a face that bulges promises most") {
    Mesh mesh = icosphere(3);
    for (const std::int32_t v : mesh.triangles[100]) mesh.vertices[at(v)] *= 1.1;
    SurfaceMeter meter(unit_sphere());
    const std::vector<double> scores =
        distance_scores(measure(RefinableMesh(on_grid(mesh, unit_grid), unit_grid, {}), meter));
    CHECK(std::ranges::max_element(scores) - scores.begin() == 100);
}

TEST_CASE("Approach: a batch's targets lie where chords and sphere are apart least, and missing them costs") {
    const RefinableMesh state = sphere_on_grid(3);
    SurfaceMeter meter(unit_sphere());
    const MeasuredMesh before = measure(state, meter);
    const std::vector<std::int32_t> batch = select_batch(state, distance_scores(before), 40);
    REQUIRE(batch.size() == 40);
    const BatchTargets targets = fit_batch(state, batch, meter).targets;
    for (std::size_t k = 0; k < batch.size(); ++k) {
        REQUIRE(targets.new_vertices[k].has_value());
        for (std::size_t m = 0; m < 3; ++m) {
            const double radius = (*targets.new_vertices[k])[m].norm();
            CHECK(radius > 0.999);  // the middle of an edge is at 0.990
            CHECK(radius < 1.010);  // facets that touch the sphere at their middles have corners outside
            CHECK(targets.new_costs[k][m] > 0);
        }
    }
    RefinableMesh after = state;
    emit_batch(after, batch, targets, {}, {.bit_price = 0.5 * gain_of_a_bit(before)});
    CHECK(squared_distance(measure(after, meter)) < squared_distance(before));
}

namespace {

/// Two spheres beside each other along x, with their middles at `half` either way.
Mesh two_spheres(int level, double radius, double half) {
    Mesh both = icosphere(level, radius, {-half, 0, 0});
    const Mesh other = icosphere(level, radius, {half, 0, 0});
    const std::int32_t n = both.n_vertices();
    both.vertices.insert(both.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const Triangle& t : other.triangles) both.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    return both;
}

}  // namespace

TEST_CASE("Approach: pieces stay apart on their way to a surface whose pieces are not, unless they may meet") {
    const TrueSurface overlapping(two_spheres(4, 0.42, 0.4), 60'000);
    const auto pairs_after = [&](bool may_meet) {
        RefinableMesh state(on_grid(two_spheres(2, 0.38, 0.4), unit_grid), unit_grid, {});
        REQUIRE(self_intersections(state.to_mesh()).empty());
        SurfaceMeter meter(overlapping);
        const MeasuredMesh before = measure(state, meter);
        for (int batch_number = 0; batch_number < 3; ++batch_number) {
            const int n_before = state.n_vertices();
            const MeasuredMesh now = measure(state, meter);
            const auto n_split = std::ssize(
                approach(state, now, distance_scores(now), 30, meter, {.rounding = {}, .may_meet = may_meet}).records);
            CHECK(n_split <= 30);
            CHECK(n_split >= (may_meet ? 30 : 20));  // the more that meet, the fewer are at hand instead
            CHECK(state.n_vertices() == n_before + 3 * n_split);
        }
        CHECK(squared_distance(measure(state, meter)) < 0.3 * squared_distance(before));
        return self_intersections(state.to_mesh()).size();
    };
    CHECK(pairs_after(false) == 0);
    CHECK(pairs_after(true) > 0);
}

TEST_CASE("Approach: where faces met before, others are split instead, if there are") {
    const TrueSurface overlapping(two_spheres(4, 0.42, 0.4), 60'000);
    const RefinableMesh state(on_grid(two_spheres(2, 0.42, 0.4), unit_grid), unit_grid, {});
    SurfaceMeter meter(overlapping);
    const auto split = [&](const std::vector<double>& scores) {
        RefinableMesh after = state;
        const std::vector<SplitRecord> records = approach(after, measure(state, meter), scores, 1, meter, {}).records;
        REQUIRE(records.size() == 1);
        return records[0].face;
    };
    const Mesh mesh = state.to_mesh();
    const auto pairs = self_intersections(mesh);
    REQUIRE(!pairs.empty());
    const std::int32_t meets = pairs.front().first;
    const auto leftmost = std::ranges::min_element(mesh.triangles, {}, [&](const Triangle& t) {
        return mesh.vertices[at(t[0])].x() + mesh.vertices[at(t[1])].x() + mesh.vertices[at(t[2])].x();
    });
    const auto meets_none = static_cast<std::int32_t>(leftmost - mesh.triangles.begin());
    std::vector<double> scores(mesh.triangles.size(), 0.0);
    scores[at(meets)] = 2;
    CHECK(split(scores) == meets);
    scores[at(meets_none)] = 1;
    CHECK(split(scores) == meets_none);
}

namespace {

double middle_x(const Mesh& mesh, const Triangle& t) {
    return (mesh.vertices[at(t[0])].x() + mesh.vertices[at(t[1])].x() + mesh.vertices[at(t[2])].x()) / 3;
}

/// The mesh itself on the left, a larger one on the right.
Mesh swollen_on_the_right(Mesh mesh) {
    for (Vec3& v : mesh.vertices)
        if (v.x() > 0) v *= 1 + 0.05 * v.x();
    return mesh;
}

}  // namespace

TEST_CASE("Approach: splits that do harm give way to others, and are told") {
    const RefinableMesh state = sphere_on_grid(3);
    const Mesh mesh = state.to_mesh();
    const TrueSurface surface(swollen_on_the_right(mesh), 60'000);
    SurfaceMeter meter(surface);
    const MeasuredMesh now = measure(state, meter);
    // Where the mesh is the surface there is nothing to gain, whatever a score says.
    std::vector<double> on_the_left(mesh.triangles.size(), 0.0), scores(mesh.triangles.size(), 0.0);
    for (std::size_t f = 0; f < scores.size(); ++f) {
        const double x = middle_x(mesh, mesh.triangles[f]);
        if (x < -0.7) on_the_left[f] = 1;
        if (x > 0) scores[f] = 1;
    }
    const std::vector<std::int32_t> left = select_batch(state, on_the_left, 4);
    REQUIRE(left.size() == 4);
    for (const std::int32_t face : left) scores[at(face)] = 2;
    const auto approach_by = [&](int n_splits) {
        RefinableMesh after = state;
        return approach(after, now, scores, n_splits, meter, {});
    };
    const ApproachStep step = approach_by(20);
    CHECK(step.records.size() == 20);
    CHECK(step.rejected == left);
    for (const SplitRecord& record : step.records) CHECK(middle_x(mesh, mesh.triangles[at(record.face)]) > 0);

    for (double& score : scores) score = score == 2 ? 1 : 0;
    const ApproachStep harmful = approach_by(3);  // the count has to be met
    CHECK(harmful.records.size() == 3);
    CHECK(harmful.rejected.size() == 1);
}
