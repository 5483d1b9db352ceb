#include "core/reconstruction/image_step.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/parallel.h"
#include "core/progressive/batch_selection.h"
#include "core/progressive/emit_batch.h"
#include "core/progressive/trial_batch.h"
#include "core/reconstruction/optimise_surface.h"

namespace anyrate {
namespace {

constexpr double phi_weight = 0.3;  ///< in a face's score, beside the gain that is expected
constexpr int most_attempts = 3;    ///< to make a batch lower Psi by leaving splits out

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Decrease of phi that a split can bring: each new vertex alone steps to the minimum of its own parabola.
double expected_gain(const TriangleTerms& terms) {
    double gain = 0;
    for (std::size_t m = 0; m < 3; ++m)
        if (terms.middle_hessian[m] > 0)
            gain += 0.5 * terms.middle_gradient[m] * terms.middle_gradient[m] / terms.middle_hessian[m];
    return gain;
}

/// What a split of each face promises by what the images say: the decrease that is expected, and a part of phi, since
/// a parabola knows of the nearest minimum only. Of nefertiti, pot and bowl errors are up to 2 % larger by the gain
/// alone; by phi alone nefertiti's are up to 3 % larger, the bowl's 1 % smaller.
std::vector<double> photo_scores(std::span<const TriangleTerms> terms) {
    std::vector<double> scores;
    scores.reserve(terms.size());
    for (const TriangleTerms& t : terms) scores.push_back(expected_gain(t) + phi_weight * t.distortion.phi);
    return scores;
}

std::vector<TriangleDistortion> distortions_of(std::span<const TriangleTerms> terms) {
    std::vector<TriangleDistortion> result;
    result.reserve(terms.size());
    for (const TriangleTerms& t : terms) result.push_back(t.distortion);
    return result;
}

/// Mean of phi per sample over the faces around some vertices; nullopt where nothing is seen.
std::optional<double> mean_phi_around(const OneRings& rings, std::span<const TriangleDistortion> distortions,
                                      std::span<const std::int32_t> vertices) {
    double phi = 0, n_samples = 0;
    for (std::int32_t f : faces_around(rings, vertices)) {
        phi += distortions[at(f)].phi;
        n_samples += distortions[at(f)].n_samples;
    }
    if (n_samples == 0) return std::nullopt;
    return phi / n_samples;
}

/// A surface that a batch changed, with what the images say of it.
struct Refined {
    const Mesh& mesh;
    std::span<const TriangleDistortion> distortions;  ///< one per face; those near the splits will do
};

/// By how much the images agree better around a split than before it: mean phi of a sample, before less after; 0 where
/// that cannot be told.
struct SplitGain {
    std::int32_t face = 0;
    double gain = 0;
};

/// @param faces      that were split
/// @param first_new  per face the first of its three new vertices
std::vector<SplitGain> photo_gains(const RefinableMesh& state, const StateDistortion& before, const Refined& after,
                                   std::span<const std::int32_t> faces, std::span<const std::int32_t> first_new) {
    const Mesh old_mesh = state.to_mesh();
    const OneRings old_rings(old_mesh), new_rings(after.mesh);
    const std::vector<TriangleDistortion> old_distortions = distortions_of(before.terms);
    std::vector<SplitGain> gains(faces.size());
    parallel_for(faces.size(), [&](std::size_t i) {
        gains[i].face = faces[i];
        const auto site = state.split_site(faces[i]);
        // An earlier split of the batch turned the face: its surroundings before are not known.
        if (!site || first_new[i] < 0) return;
        std::vector<std::int32_t> nine{first_new[i], first_new[i] + 1, first_new[i] + 2};
        nine.insert(nine.end(), site->begin(), site->end());
        const auto was = mean_phi_around(old_rings, old_distortions, *site);
        const auto is = mean_phi_around(new_rings, after.distortions, nine);
        if (was && is) gains[i].gain = *was - *is;
    });
    return gains;
}

/// A batch as it would be with scalars of any size, and what each of its splits brings there.
struct OptimisedBatch {
    BatchTargets targets;
    std::vector<SplitGain> gains;
};

/// Splits the batch on a copy of the state, moves the nine vertices of each split to where the images agree most.
OptimisedBatch optimise_batch(const RefinableMesh& state, const StateDistortion& now,
                              std::span<const std::int32_t> batch, PhotoBackend& backend, const RefinementScene& scene,
                              const RefineOptions& options, const std::stop_token& stop) {
    TrialBatch trial = try_batch(state, batch);
    Mesh& mesh = trial.mesh;
    const std::vector<char> is_guessed = scene.guessed.vertices(mesh);
    std::vector<std::int32_t> active = trial.active;
    std::erase_if(active, [&](std::int32_t v) { return is_guessed[at(v)] != 0; });
    OptimiseOptions optimise;
    optimise.rounds = 1;  // of visibility: the surface hardly moves
    optimise.steps_per_round = 3;
    optimise.tangential = 0;  // the operation smooths tangentially by itself
    optimise.bending = 0.01;  // with 0.04 nefertiti is 3 % and the pot 7 % worse; with 0 faces cut each other
    optimise.samples_per_px = options.samples_per_px;
    if (!active.empty())
        optimise_surface(backend, scene.silhouettes, mesh.vertices, mesh.triangles, active, is_guessed, optimise, stop);
    if (stop.stop_requested()) return {};  // nobody takes it, and the backend may hold another surface
    std::vector<TriangleDistortion> distortions(mesh.triangles.size());
    if (!active.empty()) {  // the backend still holds the surface
        const std::vector<std::int32_t> faces = faces_around(OneRings(mesh), active);
        std::vector<TriangleQuery> queries;
        for (const std::int32_t f : faces) queries.push_back(query_of(mesh, f));
        const std::vector<TriangleDistortion> near = backend.distortions(queries);
        for (std::size_t i = 0; i < faces.size(); ++i) distortions[at(faces[i])] = near[i];
    }
    return {targets_of(trial, state.n_vertices()),
            photo_gains(state, now, {mesh, distortions}, batch, trial.first_new)};
}

/// Emits the batch on a copy of the state, without the faces that are left out.
RefinementStep try_step(const RefinableMesh& state, std::span<const std::int32_t> batch, const BatchTargets& targets,
                        std::span<const std::int32_t> left_out, PhotoBackend& backend, const RefineOptions& options) {
    RefinementStep step{state, {}, {}, {}};
    step.records = emit_batch(step.state, batch, targets, left_out, {});
    step.distortion = measure_state(backend, step.state, options.samples_per_px);
    return step;
}

/// Adds to `left_out`, ascending, the splits that do harm, and while more than `most` are left, those that gain least.
/// @param rejected  gets those that do harm
/// @return whether it added any
bool leave_out(std::vector<SplitGain> gains, std::size_t most, std::vector<std::int32_t>& left_out,
               std::vector<std::int32_t>& rejected) {
    std::ranges::stable_sort(gains, std::greater<>(), &SplitGain::gain);
    const std::size_t n_before = left_out.size();
    for (std::size_t i = 0; i < gains.size(); ++i) {
        const bool harms = gains[i].gain < 0;
        if (harms) rejected.push_back(gains[i].face);
        if (harms || i >= most) left_out.push_back(gains[i].face);
    }
    std::sort(left_out.begin(), left_out.end());
    return left_out.size() > n_before;
}

std::vector<SplitGain> photo_gains(const RefinableMesh& state, const StateDistortion& before,
                                   const RefinementStep& step) {
    const Mesh mesh = step.state.to_mesh();
    std::vector<std::int32_t> faces, first_new;
    for (const SplitRecord& record : step.records) {
        first_new.push_back(state.n_vertices() + 3 * static_cast<std::int32_t>(faces.size()));
        faces.push_back(record.face);
    }
    return photo_gains(state, before, {mesh, distortions_of(step.distortion->terms)}, faces, first_new);
}

/// The batch as far as it lowers Psi: without the splits that did harm where they are when they were tried, and while
/// Psi does not fall, without those that turn out to.
/// @param most      splits
/// @param rejected  gets the faces whose splits did harm
/// @return nullopt if no part of it lowers Psi
std::optional<RefinementStep> take_step(const RefinableMesh& state, const StateDistortion& now,
                                        std::span<const std::int32_t> batch, std::size_t most,
                                        const OptimisedBatch& optimised, PhotoBackend& backend,
                                        const RefineOptions& options, std::vector<std::int32_t>& rejected) {
    std::vector<std::int32_t> left_out;
    if (!options.by_area) leave_out(optimised.gains, most, left_out, rejected);
    for (int attempt = 0; attempt < most_attempts; ++attempt) {
        RefinementStep step = try_step(state, batch, optimised.targets, left_out, backend, options);
        if (options.by_area || step.distortion->point.mean < now.point.mean) return step;
        if (!leave_out(photo_gains(state, now, step), most, left_out, rejected)) break;
    }
    return std::nullopt;
}

/// The faces of a batch that are not among its `n` of highest score, ascending.
std::vector<std::int32_t> all_but(int n, std::span<const std::int32_t> batch, const RefinableMesh& state,
                                  std::span<const double> scores) {
    std::vector<std::int32_t> rest;
    std::ranges::set_difference(batch, select_batch(state, scores, n), std::back_inserter(rest));
    return rest;
}

}  // namespace

std::optional<RefinementStep> follow_images(const RefinableMesh& state, const StateDistortion& now,
                                            PhotoBackend& backend, const RefinementScene& scene,
                                            const RefineOptions& options, const std::stop_token& stop,
                                            std::span<const char> is_rejected) {
    const Mesh mesh = state.to_mesh();
    const std::vector<char> is_guessed = scene.guessed.vertices(mesh);
    const BatchSize size = batch_size(state.n_vertices(), options.followed_growth, options);
    const std::vector<double> scores = split_scores(mesh, photo_scores(now.terms), is_guessed, is_rejected, options);
    const std::vector<std::int32_t> batch = select_batch(state, scores, size.tried);
    if (batch.empty()) return std::nullopt;
    const OptimisedBatch optimised = optimise_batch(state, now, batch, backend, scene, options, stop);
    if (stop.stop_requested()) return std::nullopt;  // half optimised, it is not what an undisturbed run makes
    std::vector<std::int32_t> rejected;
    std::optional<RefinementStep> step =
        take_step(state, now, batch, at(size.taken), optimised, backend, options, rejected);
    // The count has to be met. Other batches tried first, three in a row, cost the bowl 1.2 s and gain nothing.
    if (!step)
        step = try_step(state, batch, optimised.targets, all_but(size.taken, batch, state, scores), backend, options);
    step->rejected = std::move(rejected);
    return step;
}

}  // namespace anyrate
