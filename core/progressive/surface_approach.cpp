#include "core/progressive/surface_approach.h"

#include <cmath>

#include "core/mesh/triangle_shape.h"
#include "core/mesh/vertex_fit.h"
#include "core/progressive/trial_batch.h"

namespace anyrate {
namespace {

constexpr double bits_per_vertex = 13;   ///< that a log takes, roughly: what a split costs
constexpr double neighbour_share = 0.4;  ///< of a neighbour's error that a split removes; 0: a pot 1 to 3 % worse

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace

MeasuredMesh measure(const RefinableMesh& state, SurfaceMeter& meter) {
    MeasuredMesh now{state.to_mesh(), {}, {}};
    now.faces = meter.distances(now.mesh);
    now.twins.resize(3 * now.faces.size());
    for (std::size_t h = 0; h < now.twins.size(); ++h) now.twins[h] = state.twin(static_cast<std::int32_t>(h));
    return now;
}

double squared_distance(const MeasuredMesh& now) {
    double sum = 0;
    for (const FaceDistance& face : now.faces) sum += face.squared;
    return sum;
}

std::vector<double> distance_scores(const MeasuredMesh& now, double noise) {
    std::vector<double> errors(now.faces.size());
    for (std::size_t f = 0; f < errors.size(); ++f) {
        const auto& [a, b, c] = now.mesh.triangles[f];
        const auto& v = now.mesh.vertices;
        const double area = 0.5 * twice_area_vector(v[at(a)], v[at(b)], v[at(c)]).norm();
        const FaceDistance& face = now.faces[f];
        if (face.area > 0) errors[f] = area * (std::sqrt(face.squared / face.area + noise * noise) - noise);
    }
    std::vector<double> scores(errors.size());
    for (std::size_t f = 0; f < scores.size(); ++f) {
        double sum = errors[f];
        for (std::size_t k = 0; k < 3; ++k) sum += neighbour_share * errors[at(now.twins[3 * f + k] / 3)];
        scores[f] = sum / (1 + 3 * neighbour_share);
    }
    return scores;
}

BatchTargets fit_batch(const RefinableMesh& state, std::span<const std::int32_t> batch, SurfaceMeter& meter) {
    TrialBatch trial = try_batch(state, batch);
    const std::vector<double> costs = fit_vertices(trial.mesh, trial.active, meter, {});
    BatchTargets targets = targets_of(trial, state.n_vertices());
    targets.old_costs.assign(costs.begin(), costs.begin() + state.n_vertices());
    targets.new_costs.resize(batch.size());
    for (std::size_t k = 0; k < batch.size(); ++k)
        if (const std::int32_t v = trial.first_new[k]; v >= 0)
            targets.new_costs[k] = {costs[at(v)], costs[at(v + 1)], costs[at(v + 2)]};
    return targets;
}

double gain_of_a_bit(const MeasuredMesh& now) {
    return 2 * squared_distance(now) / (now.mesh.n_vertices() * bits_per_vertex);
}

}  // namespace anyrate
