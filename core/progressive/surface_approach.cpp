#include "core/progressive/surface_approach.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/keep_apart.h"
#include "core/mesh/triangle_shape.h"
#include "core/mesh/vertex_fit.h"
#include "core/progressive/trial_batch.h"

namespace anyrate {
namespace {

constexpr double bits_per_vertex = 13;   ///< that a log takes, roughly: what a split costs
constexpr double neighbour_share = 0.4;  ///< of a neighbour's error that a split removes; 0: a pot 1 to 3 % worse

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// The faces of the batch whose splits made a face of the pairs, ascending.
std::vector<std::int32_t> splits_of(std::span<const std::pair<std::int32_t, std::int32_t>> pairs,
                                    const TrialBatch& trial, std::span<const std::int32_t> batch) {
    std::vector<std::int32_t> split_of(trial.mesh.vertices.size(), -1);  // that a vertex is new by
    for (std::size_t k = 0; k < batch.size(); ++k)
        for (std::int32_t i = 0; trial.first_new[k] >= 0 && i < 3; ++i) split_of[at(trial.first_new[k] + i)] = batch[k];
    std::vector<std::int32_t> splits;
    for (const auto& [f, g] : pairs)
        for (const std::int32_t face : {f, g})
            for (const std::int32_t v : trial.mesh.triangles[at(face)])
                if (split_of[at(v)] >= 0) splits.push_back(split_of[at(v)]);
    std::ranges::sort(splits);
    const auto repeated = std::ranges::unique(splits);
    splits.erase(repeated.begin(), repeated.end());
    return splits;
}

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

FittedBatch fit_batch(const RefinableMesh& state, std::span<const std::int32_t> batch, SurfaceMeter& meter,
                      bool may_meet) {
    TrialBatch trial = try_batch(state, batch);
    const std::vector<Vec3> before(trial.mesh.vertices);
    const std::vector<double> costs = fit_vertices(trial.mesh, trial.active, meter, {});
    FittedBatch fitted;
    if (!may_meet) fitted.left_out = splits_of(keep_apart(trial.mesh, before), trial, batch);
    if (std::ssize(fitted.left_out) == std::ranges::count_if(trial.first_new, [](std::int32_t v) { return v >= 0; }))
        fitted.left_out.clear();
    BatchTargets& targets = fitted.targets;
    targets = targets_of(trial, state.n_vertices());
    targets.old_costs.assign(costs.begin(), costs.begin() + state.n_vertices());
    targets.new_costs.resize(batch.size());
    for (std::size_t k = 0; k < batch.size(); ++k)
        if (const std::int32_t v = trial.first_new[k]; v >= 0)
            targets.new_costs[k] = {costs[at(v)], costs[at(v + 1)], costs[at(v + 2)]};
    return fitted;
}

double gain_of_a_bit(const MeasuredMesh& now) {
    return 2 * squared_distance(now) / (now.mesh.n_vertices() * bits_per_vertex);
}

}  // namespace anyrate
