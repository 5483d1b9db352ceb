#include "core/progressive/surface_approach.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/mesh/self_intersections.h"
#include "core/mesh/triangle_shape.h"
#include "core/mesh/vertex_fit.h"
#include "core/progressive/batch_selection.h"
#include "core/progressive/split_gains.h"
#include "core/progressive/trial_batch.h"

namespace anyrate {
namespace {

constexpr double bits_per_vertex = 13;  ///< that a log takes, roughly: what a split costs
constexpr double tried = 1.5;           ///< splits for each one that is taken; 1.25: 1 % worse at 5,000, 2: the same
constexpr int fewest_spare = 2;         ///< of a batch however small
constexpr double most_usual = 30;       ///< medians of a face's mean squared distance

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

/// The faces of a batch with the highest scores first, but those whose splits do harm last.
std::vector<std::int32_t> by_priority(std::span<const std::int32_t> batch, std::span<const double> scores,
                                      std::span<const double> gains) {
    std::vector<std::size_t> order(batch.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](std::size_t k) { return std::pair(gains[k] < 0, -scores[at(batch[k])]); });
    std::vector<std::int32_t> faces;
    for (const std::size_t k : order) faces.push_back(batch[k]);
    return faces;
}

/// Those of a batch, ascending, that are not among the first `n` of some.
std::vector<std::int32_t> all_but_first(std::size_t n, std::span<const std::int32_t> some,
                                        std::span<const std::int32_t> batch) {
    const auto first = some.first(std::min(n, some.size()));
    std::vector<std::int32_t> taken(first.begin(), first.end()), rest;
    std::ranges::sort(taken);
    std::ranges::set_difference(batch, taken, std::back_inserter(rest));
    return rest;
}

/// Splits the first `n_splits` faces that have no faces meet; if all do, since the count has to be met, the first ones.
/// @param ordered  the faces of the batch
EmittedBatch emit_apart(const RefinableMesh& state, std::span<const std::int32_t> batch,
                        std::span<const std::int32_t> ordered, int n_splits, const BatchTargets& targets,
                        const ApproachOptions& options) {
    const auto emit_first_of = [&](std::span<const std::int32_t> faces) {
        EmittedBatch emitted{state, {}};
        emitted.records =
            emit_batch(emitted.state, batch, targets, all_but_first(at(n_splits), faces, batch), options.rounding);
        return emitted;
    };
    if (options.may_meet) return emit_first_of(ordered);
    for (std::vector<std::int32_t> left(ordered.begin(), ordered.end());;) {
        EmittedBatch emitted = emit_first_of(left);
        if (emitted.records.empty()) return emit_first_of(ordered);
        const std::vector<std::int32_t> meeting =
            splits_around(self_intersections(emitted.state.to_mesh()), state, emitted.state, emitted.records);
        if (meeting.empty()) return emitted;
        std::erase_if(left, [&](std::int32_t face) { return std::ranges::binary_search(meeting, face); });
    }
}

/// Of the squared distances of the faces, world units squared; 0 if none was measured.
double median_mean_square(std::span<const FaceDistance> faces) {
    std::vector<double> mean_squares;
    for (const FaceDistance& face : faces)
        if (face.area > 0) mean_squares.push_back(face.squared / face.area);
    if (mean_squares.empty()) return 0;
    const auto middle = mean_squares.begin() + std::ssize(mean_squares) / 2;
    std::ranges::nth_element(mean_squares, middle);
    return *middle;
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

FittedBatch fit_batch(const RefinableMesh& state, std::span<const std::int32_t> batch, SurfaceMeter& meter) {
    FittedBatch fitted{try_batch(state, batch), {}};
    TrialBatch& trial = fitted.trial;
    const std::vector<double> costs = fit_vertices(trial.mesh, trial.active, meter, {});
    BatchTargets& targets = fitted.targets = targets_of(trial, state.n_vertices());
    targets.old_costs.assign(costs.begin(), costs.begin() + state.n_vertices());
    targets.new_costs.resize(batch.size());
    for (std::size_t k = 0; k < batch.size(); ++k)
        if (const std::int32_t v = trial.first_new[k]; v >= 0)
            targets.new_costs[k] = {costs[at(v)], costs[at(v + 1)], costs[at(v + 2)]};
    return fitted;
}

ApproachStep approach(RefinableMesh& state, const MeasuredMesh& now, std::span<const double> scores, int n_splits,
                      SurfaceMeter& meter, const ApproachOptions& options) {
    const int n_tried = std::max(n_splits + fewest_spare, static_cast<int>(tried * n_splits));
    const std::vector<std::int32_t> batch = select_batch(state, scores, n_tried);
    if (batch.empty()) return {};
    const FittedBatch fitted = fit_batch(state, batch, meter);
    const MeasuredMesh then{fitted.trial.mesh, meter.distances(fitted.trial.mesh)};
    const std::vector<double> gains = split_gains(
        state, batch, fitted.trial, {distance_scores(now, options.noise), distance_scores(then, options.noise)});
    EmittedBatch emitted =
        emit_apart(state, batch, by_priority(batch, scores, gains), n_splits, fitted.targets, options);
    ApproachStep step{std::move(emitted.records), {}};
    for (std::size_t k = 0; k < batch.size(); ++k)
        if (gains[k] < 0 && !std::ranges::binary_search(step.records, batch[k], {}, &SplitRecord::face))
            step.rejected.push_back(batch[k]);
    state = std::move(emitted.state);
    return step;
}

double gain_of_a_bit(const MeasuredMesh& now) {
    const double most = most_usual * median_mean_square(now.faces);
    double usual = 0;
    for (const FaceDistance& face : now.faces) usual += std::min(face.squared, most * face.area);
    return 2 * usual / (now.mesh.n_vertices() * bits_per_vertex);
}

}  // namespace anyrate
