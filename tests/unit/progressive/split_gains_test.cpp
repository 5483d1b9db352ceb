#include "core/progressive/split_gains.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "core/progressive/base_on_grid.h"
#include "core/progressive/batch_selection.h"
#include "core/simulation/parametric_meshes.h"

using namespace anyrate;

namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

RefinableMesh torus_on_grid() {
    const Mesh mesh = torus(0.6, 0.25, 40, 20);
    const Grid grid = make_grid(mesh, 10'000);
    return {to_base(mesh, grid), grid, {}};
}

std::vector<double> random_costs(std::size_t n, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> cost(0, 1);
    std::vector<double> costs(n);
    for (double& c : costs) c = cost(random);
    return costs;
}

/// Sum over the faces that have one of the vertices.
double sum_around(std::span<const std::int32_t> vertices, std::span<const Triangle> faces,
                  std::span<const double> costs) {
    double sum = 0;
    for (std::size_t f = 0; f < faces.size(); ++f)
        if (std::ranges::any_of(faces[f], [&](std::int32_t v) { return std::ranges::count(vertices, v) > 0; }))
            sum += costs[f];
    return sum;
}

}  // namespace

TEST_CASE("Split gains: faces that cost one each cost six more after a split") {
    const RefinableMesh state = torus_on_grid();
    const std::vector<std::int32_t> batch{0, state.n_faces() / 2};
    const TrialBatch trial = try_batch(state, batch);
    const std::vector<double> before(at(state.n_faces()), 1.0), after(trial.mesh.triangles.size(), 1.0);
    for (const double gain : split_gains(state, batch, trial, {before, after})) CHECK(gain == doctest::Approx(-6));
}

TEST_CASE("Split gains: together they are what all faces at the splits cost before, less what they cost after") {
    const RefinableMesh state = torus_on_grid();
    const std::vector<std::int32_t> batch =
        select_batch(state, random_costs(at(state.n_faces()), 1), 60);  // crowded: faces touch two or three splits
    const TrialBatch trial = try_batch(state, batch);
    const std::vector<double> before = random_costs(at(state.n_faces()), 2),
                              after = random_costs(trial.mesh.triangles.size(), 3);
    const std::vector<double> gains = split_gains(state, batch, trial, {before, after});
    REQUIRE(gains.size() == batch.size());
    CHECK(std::accumulate(gains.begin(), gains.end(), 0.0) ==
          doctest::Approx(sum_around(trial.active, state.triangles(), before) -
                          sum_around(trial.active, trial.mesh.triangles, after)));
}

TEST_CASE("Split gains: a split has them all of what is around it alone") {
    const RefinableMesh state = torus_on_grid();
    const std::vector<std::int32_t> batch{0, state.n_faces() / 2};
    const TrialBatch trial = try_batch(state, batch);
    const std::vector<double> before = random_costs(at(state.n_faces()), 4),
                              after = random_costs(trial.mesh.triangles.size(), 5);
    const std::vector<double> gains = split_gains(state, batch, trial, {before, after});
    for (std::size_t k = 0; k < batch.size(); ++k) {
        const auto site = state.split_site(batch[k]);
        REQUIRE(site.has_value());
        std::vector<std::int32_t> nine(site->begin(), site->end());
        for (std::int32_t i = 0; i < 3; ++i) nine.push_back(trial.first_new[k] + i);
        CHECK(gains[k] == doctest::Approx(sum_around(nine, state.triangles(), before) -
                                          sum_around(nine, trial.mesh.triangles, after)));
    }
}
