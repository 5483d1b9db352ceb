#include "core/progressive/surface_approach.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "core/mesh/self_intersections.h"
#include "core/mesh/triangle_shape.h"
#include "core/mesh/vertex_fit.h"
#include "core/progressive/batch_selection.h"
#include "core/progressive/trial_batch.h"

namespace anyrate {
namespace {

constexpr double bits_per_vertex = 13;  ///< that a log takes, roughly: what a split costs
constexpr double spare = 0.02;          ///< of a batch: splits for those that have faces meet
constexpr int fewest_spare = 2;         ///< of a batch however small

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
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    return faces;
}

/// A batch on a copy of the state.
struct EmittedBatch {
    RefinableMesh state;
    std::vector<SplitRecord> records;
};

/// Splits the `n_splits` faces of highest scores that have no faces meet.
/// @param batch  these, and some more
EmittedBatch emit_apart(const RefinableMesh& state, std::span<const std::int32_t> batch, std::span<const double> scores,
                        int n_splits, const BatchTargets& targets, const Rounding& rounding) {
    std::vector<std::int32_t> by_score(batch.begin(), batch.end());
    std::ranges::stable_sort(by_score, std::greater<>(), [&](std::int32_t face) { return scores[at(face)]; });
    for (;;) {
        const auto n_taken = std::min<std::ptrdiff_t>(n_splits, std::ssize(by_score));
        std::vector<std::int32_t> taken(by_score.begin(), by_score.begin() + n_taken), left_out;
        std::ranges::sort(taken);
        std::ranges::set_difference(batch, taken, std::back_inserter(left_out));
        EmittedBatch emitted{state, {}};
        emitted.records = emit_batch(emitted.state, batch, targets, left_out, rounding);
        const std::vector<std::int32_t> meeting =
            splits_around(self_intersections(emitted.state.to_mesh()), state, emitted.state, emitted.records);
        if (meeting.empty()) return emitted;
        std::erase_if(by_score, [&](std::int32_t face) { return std::ranges::binary_search(meeting, face); });
    }
}

}  // namespace

MeasuredMesh measure(const RefinableMesh& state, SurfaceMeter& meter) {
    MeasuredMesh now{state.to_mesh(), {}};
    now.faces = meter.distances(now.mesh);
    return now;
}

double squared_distance(const MeasuredMesh& now) {
    double sum = 0;
    for (const FaceDistance& face : now.faces) sum += face.squared;
    return sum;
}

std::vector<double> distance_scores(const MeasuredMesh& now, double noise) {
    std::vector<double> scores(now.faces.size());
    for (std::size_t f = 0; f < scores.size(); ++f) {
        const auto& [a, b, c] = now.mesh.triangles[f];
        const auto& v = now.mesh.vertices;
        const double area = 0.5 * twice_area_vector(v[at(a)], v[at(b)], v[at(c)]).norm();
        const FaceDistance& face = now.faces[f];
        if (face.area > 0) scores[f] = area * (std::sqrt(face.squared / face.area + noise * noise) - noise);
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

std::vector<SplitRecord> approach(RefinableMesh& state, std::span<const double> scores, int n_splits,
                                  SurfaceMeter& meter, const Rounding& rounding, bool may_meet) {
    const int n_spare = may_meet ? 0 : std::max(fewest_spare, static_cast<int>(spare * n_splits));
    const std::vector<std::int32_t> batch = select_batch(state, scores, n_splits + n_spare);
    if (batch.empty()) return {};
    const BatchTargets targets = fit_batch(state, batch, meter);
    if (may_meet) return emit_batch(state, batch, targets, {}, rounding);
    EmittedBatch emitted = emit_apart(state, batch, scores, n_splits, targets, rounding);
    if (emitted.records.empty())  // the count has to be met
        return emit_batch(state, batch, targets, std::span(batch).subspan(std::min(batch.size(), at(n_splits))),
                          rounding);
    state = std::move(emitted.state);
    return std::move(emitted.records);
}

double gain_of_a_bit(const MeasuredMesh& now) {
    return 2 * squared_distance(now) / (now.mesh.n_vertices() * bits_per_vertex);
}

}  // namespace anyrate
