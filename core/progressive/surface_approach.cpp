#include "core/progressive/surface_approach.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/keep_apart.h"
#include "core/mesh/self_intersections.h"
#include "core/mesh/triangle_shape.h"
#include "core/mesh/vertex_fit.h"
#include "core/progressive/batch_selection.h"
#include "core/progressive/trial_batch.h"

namespace anyrate {
namespace {

constexpr double bits_per_vertex = 13;   ///< that a log takes, roughly: what a split costs
constexpr double neighbour_share = 0.4;  ///< of a neighbour's error that a split removes; 0: a pot 1 to 3 % worse

constexpr int most_attempts = 3;  ///< of a batch whose splits have faces meet

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// The faces of the splits that moved or made a corner of the pairs' faces, ascending. No vertex is moved by two.
/// @param records  of the batch that made `after` of `before`
std::vector<std::int32_t> splits_around(std::span<const std::pair<std::int32_t, std::int32_t>> pairs,
                                        const RefinableMesh& before, const RefinableMesh& after,
                                        std::span<const SplitRecord> records) {
    if (pairs.empty()) return {};
    std::vector<std::int32_t> split_of(at(after.n_vertices()), -1);
    std::int32_t new_vertex = before.n_vertices();
    for (const SplitRecord& record : records) {
        for (int i = 0; i < 3; ++i) split_of[at(new_vertex++)] = record.face;
        if (const auto site = before.split_site(record.face))
            for (const std::int32_t v : *site) split_of[at(v)] = record.face;
    }
    std::vector<std::int32_t> faces;
    for (const auto& [f, g] : pairs)
        for (const std::int32_t face : {f, g})
            for (const std::int32_t v : after.triangles()[at(face)])
                if (split_of[at(v)] >= 0) faces.push_back(split_of[at(v)]);
    std::ranges::sort(faces);
    const auto repeated = std::ranges::unique(faces);
    faces.erase(repeated.begin(), repeated.end());
    return faces;
}

/// The faces of the batch without which no split has faces meet, ascending.
std::vector<std::int32_t> splits_that_meet(const RefinableMesh& state, std::span<const std::int32_t> batch,
                                           const BatchTargets& targets, const Rounding& rounding) {
    std::vector<std::int32_t> left_out;
    for (;;) {
        RefinableMesh after = state;
        const std::vector<SplitRecord> records = emit_batch(after, batch, targets, left_out, rounding);
        const std::vector<std::int32_t> more =
            splits_around(self_intersections(after.to_mesh()), state, after, records);
        if (more.empty()) return left_out;
        left_out.insert(left_out.end(), more.begin(), more.end());
        std::ranges::sort(left_out);
    }
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

BatchTargets fit_batch(const RefinableMesh& state, std::span<const std::int32_t> batch, SurfaceMeter& meter,
                       bool may_meet) {
    TrialBatch trial = try_batch(state, batch);
    const std::vector<Vec3> before(trial.mesh.vertices);
    const std::vector<double> costs = fit_vertices(trial.mesh, trial.active, meter, {});
    if (!may_meet) keep_apart(trial.mesh, before);
    BatchTargets targets = targets_of(trial, state.n_vertices());
    targets.old_costs.assign(costs.begin(), costs.begin() + state.n_vertices());
    targets.new_costs.resize(batch.size());
    for (std::size_t k = 0; k < batch.size(); ++k)
        if (const std::int32_t v = trial.first_new[k]; v >= 0)
            targets.new_costs[k] = {costs[at(v)], costs[at(v + 1)], costs[at(v + 2)]};
    return targets;
}

std::vector<SplitRecord> approach(RefinableMesh& state, std::vector<double> scores, int n_splits, SurfaceMeter& meter,
                                  const Rounding& rounding, bool may_meet) {
    std::vector<std::int32_t> batch = select_batch(state, scores, n_splits);
    if (batch.empty()) return {};
    for (int attempt = 1;; ++attempt) {
        const BatchTargets targets = fit_batch(state, batch, meter, may_meet);
        std::vector<std::int32_t> left_out;
        if (!may_meet) left_out = splits_that_meet(state, batch, targets, rounding);
        if (!left_out.empty() && attempt < most_attempts) {
            for (const std::int32_t face : left_out) scores[at(face)] = 0;
            if (auto others = select_batch(state, scores, n_splits); !others.empty()) {
                batch = std::move(others);
                continue;
            }
        }
        std::vector<SplitRecord> records = emit_batch(state, batch, targets, left_out, rounding);
        if (records.empty()) records = emit_batch(state, batch, targets, {}, rounding);  // the count has to be met
        return records;
    }
}

double gain_of_a_bit(const MeasuredMesh& now) {
    return 2 * squared_distance(now) / (now.mesh.n_vertices() * bits_per_vertex);
}

}  // namespace anyrate
