#include "core/reconstruction/refine.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>

#include "core/parallel.h"
#include "core/progressive/batch_selection.h"
#include "core/progressive/emit_batch.h"
#include "core/progressive/surface_approach.h"
#include "core/progressive/trial_batch.h"
#include "core/reconstruction/optimise_surface.h"
#include "core/reconstruction/vertex_colours.h"

namespace anyrate {
namespace {

constexpr double most_offset_edges = 0.5;  ///< a fitted surface farther off is another part of the object
constexpr double most_offset_px = 1.0;     ///< that a split is credited with: beyond, phi is no parabola

constexpr int most_attempts = 3;       ///< to make a batch lower Psi by leaving splits out
constexpr double spare_splits = 0.25;  ///< tried beyond those taken, in parts of a batch; pot at 5,000: -6 %
constexpr int fewest_tried = 40;       ///< splits of a batch
constexpr int most_refusals = 4;  ///< batches refused in a row before one is taken as it is: the count has to be met

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

double face_area(const Mesh& mesh, const Triangle& t) {
    const Vec3& a = mesh.vertices[at(t[0])];
    return 0.5 * (mesh.vertices[at(t[1])] - a).cross(mesh.vertices[at(t[2])] - a).norm();
}

/// Decrease of phi that a split can bring: each new vertex alone steps to the minimum of its own parabola.
double expected_gain(const TriangleTerms& terms) {
    double gain = 0;
    for (std::size_t m = 0; m < 3; ++m)
        if (terms.middle_hessian[m] > 0)
            gain += 0.5 * terms.middle_gradient[m] * terms.middle_gradient[m] / terms.middle_hessian[m];
    return gain;
}

/// How far the fitted surface is off along a unit normal, world units; 0 where none faces the same way.
double offset_of(const NearestSurface& fitted, const Vec3& point, const Vec3& normal) {
    const NearestSurface::Hit hit = fitted.nearest_facing(point, normal);
    return hit.face < 0 ? 0.0 : (hit.point - point).dot(normal);
}

/// Decrease of phi if the middles of a face's edges move to the fitted surface, by the curvature that phi has now.
double fitted_gain(const Mesh& mesh, std::span<const Vec3> normals, const Triangle& t, const TriangleTerms& terms,
                   const NearestSurface& fitted, double pixel_size) {
    double gain = 0;
    for (std::size_t m = 0; m < 3; ++m) {
        if (!(terms.middle_hessian[m] > 0)) continue;
        const std::size_t a = at(t[m]), b = at(t[(m + 1) % 3]);
        const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b];
        const double most = std::min(most_offset_edges * (p - q).norm(), most_offset_px * pixel_size);
        const Vec3 normal = (normals[a] + normals[b]).normalized();
        const double offset = std::clamp(offset_of(fitted, 0.5 * (p + q), normal), -most, most);
        gain += 0.5 * terms.middle_hessian[m] * offset * offset;
    }
    return gain;
}

/// Decrease of phi that a split of each face promises by what the images say, and by the fitted surface.
std::vector<double> photo_scores(const Mesh& mesh, const StateDistortion& now, const NearestSurface& fitted) {
    const std::vector<Vec3> normals = vertex_normals(mesh, OneRings(mesh));
    std::vector<double> scores(mesh.triangles.size());
    parallel_for(scores.size(), [&](std::size_t f) {
        scores[f] = expected_gain(now.terms[f]) +
                    fitted_gain(mesh, normals, mesh.triangles[f], now.terms[f], fitted, now.pixel_sizes[f]);
    });
    return scores;
}

/// What a split of each face promises; 0 for a face that is not to be split.
/// @param scores  what the evidence says; for guesses nothing is evidence
std::vector<double> split_scores(const Mesh& mesh, std::vector<double> scores, std::span<const char> is_guessed,
                                 std::span<const char> is_rejected, const RefineOptions& options) {
    const std::size_t n = mesh.triangles.size();
    std::vector<double> areas(n);
    const auto is_guess = [&](std::size_t f) {
        return std::ranges::any_of(mesh.triangles[f], [&](std::int32_t v) { return is_guessed[at(v)] != 0; });
    };
    for (std::size_t f = 0; f < n; ++f) {
        areas[f] = face_area(mesh, mesh.triangles[f]);
        if (options.by_area || is_guess(f) || is_rejected[f] != 0) scores[f] = 0;
    }
    const double mean_area = std::accumulate(areas.begin(), areas.end(), 0.0) / static_cast<double>(n);
    const double mean_score = std::accumulate(scores.begin(), scores.end(), 0.0) / static_cast<double>(n);
    // Area breaks the ties among faces without evidence, so that the budget is met on a plain or unseen surface too;
    // a guess, of which nothing is known, comes last.
    const double per_area = mean_score > 0 ? 1e-3 * mean_score / mean_area : 1.0;
    for (std::size_t f = 0; f < n; ++f) {
        const double tie = per_area * areas[f] * (is_guess(f) ? 1e-3 : 1.0);
        scores[f] = areas[f] < options.smallest_area * mean_area ? 0.0 : scores[f] + tie;
    }
    return scores;
}

/// Puts the vertices from `first` on, which are new, onto the fitted surface along their normals.
void start_on(const NearestSurface& fitted, Mesh& mesh, int first) {
    const OneRings rings(mesh);
    const std::vector<Vec3> normals = vertex_normals(mesh, rings);
    const std::vector<double> edges = mean_edge_lengths(mesh, rings);
    parallel_for(mesh.vertices.size() - at(first), [&](std::size_t i) {
        const std::size_t v = at(first) + i;
        const double most = most_offset_edges * edges[v];
        mesh.vertices[v] += std::clamp(offset_of(fitted, mesh.vertices[v], normals[v]), -most, most) * normals[v];
    });
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
std::vector<SplitGain> split_gains(const RefinableMesh& state, const StateDistortion& before, const Refined& after,
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
    start_on(scene.fitted.nearest, mesh, state.n_vertices());
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
            split_gains(state, now, {mesh, distortions}, batch, trial.first_new)};
}

/// A decoded state, what led to it and what the images say of it.
struct Step {
    RefinableMesh state;
    std::vector<SplitRecord> records;
    StateDistortion distortion;
};

/// How many splits a batch tries, and how many of them it takes at most.
struct BatchSize {
    int tried = 0, taken = 0;
};

BatchSize batch_size(int n_vertices, const RefineOptions& options) {
    const int wanted = (options.n_vertices - n_vertices) / 3;
    const int grown = std::max(1, static_cast<int>(std::lround(options.growth * n_vertices / 3)));
    // A last crumb joins its predecessor.
    const int taken = wanted < grown + grown / 3 ? wanted : grown;
    if (options.by_area) return {taken, taken};
    // The images bear some out better than was expected, others not at all. A last batch that takes few may leave a
    // crumb at the price of a whole measurement: it tries twice as many.
    const int tried = taken < grown ? std::min(2 * taken, grown) : taken;
    return {std::max(fewest_tried, static_cast<int>((1 + spare_splits) * tried)), taken};
}

/// Emits the batch on a copy of the state, without the faces that are left out.
Step try_step(const RefinableMesh& state, std::span<const std::int32_t> batch, const BatchTargets& targets,
              std::span<const std::int32_t> left_out, PhotoBackend& backend, const RefineOptions& options) {
    Step step{state, {}, {}};
    step.records = emit_batch(step.state, batch, targets, left_out, {.dead_zone = options.dead_zone});
    step.distortion = measure_state(backend, step.state, options.samples_per_px);
    return step;
}

/// Adds to `left_out`, ascending, the splits that do harm, and while more than `most` are left, those that gain least.
/// @param is_rejected  learns of those that do harm
/// @return whether it added any
bool leave_out(std::vector<SplitGain> gains, std::size_t most, std::vector<std::int32_t>& left_out,
               std::vector<char>& is_rejected) {
    std::ranges::stable_sort(gains, std::greater<>(), &SplitGain::gain);
    const std::size_t n_before = left_out.size();
    for (std::size_t i = 0; i < gains.size(); ++i) {
        const bool harms = gains[i].gain < 0;
        if (harms) is_rejected[at(gains[i].face)] = 1;
        if (harms || i >= most) left_out.push_back(gains[i].face);
    }
    std::sort(left_out.begin(), left_out.end());
    return left_out.size() > n_before;
}

std::vector<SplitGain> split_gains(const RefinableMesh& state, const StateDistortion& before, const Step& step) {
    const Mesh mesh = step.state.to_mesh();
    std::vector<std::int32_t> faces, first_new;
    for (const SplitRecord& record : step.records) {
        first_new.push_back(state.n_vertices() + 3 * static_cast<std::int32_t>(faces.size()));
        faces.push_back(record.face);
    }
    return split_gains(state, before, {mesh, distortions_of(step.distortion.terms)}, faces, first_new);
}

/// The batch as far as it lowers Psi: without the splits that did harm where they are when they were tried, and while
/// Psi does not fall, without those that turn out to.
/// @param most         splits
/// @param is_rejected  learns of the splits that did harm
/// @return nullopt if no part of it lowers Psi
std::optional<Step> take_step(const RefinableMesh& state, const StateDistortion& now,
                              std::span<const std::int32_t> batch, std::size_t most, const OptimisedBatch& optimised,
                              PhotoBackend& backend, const RefineOptions& options, std::vector<char>& is_rejected) {
    std::vector<std::int32_t> left_out;
    if (!options.by_area) leave_out(optimised.gains, most, left_out, is_rejected);
    for (int attempt = 0; attempt < most_attempts; ++attempt) {
        Step step = try_step(state, batch, optimised.targets, left_out, backend, options);
        if (options.by_area || step.distortion.point.mean < now.point.mean) return step;
        if (!leave_out(split_gains(state, now, step), most, left_out, is_rejected)) break;
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

/// A batch of which the images say that it betters the surface, or if none is found, one that is taken as it is: the
/// count has to be met.
/// @param is_rejected  learns of the splits that did harm
/// @return nullopt if nothing can be split, or on a stop
std::optional<Step> follow_images(const RefinableMesh& state, const StateDistortion& now, PhotoBackend& backend,
                                  const RefinementScene& scene, const RefineOptions& options,
                                  const std::stop_token& stop, std::vector<char>& is_rejected) {
    const Mesh mesh = state.to_mesh();
    const std::vector<char> is_guessed = scene.guessed.vertices(mesh);
    const std::vector<double> evidence = photo_scores(mesh, now, scene.fitted.nearest);
    const BatchSize size = batch_size(state.n_vertices(), options);
    for (int n_refusals = 0; !stop.stop_requested();) {
        const std::vector<double> scores = split_scores(mesh, evidence, is_guessed, is_rejected, options);
        const std::vector<std::int32_t> batch = select_batch(state, scores, size.tried);
        if (batch.empty()) break;
        const OptimisedBatch optimised = optimise_batch(state, now, batch, backend, scene, options, stop);
        if (stop.stop_requested()) break;  // half optimised, it is not the batch that an undisturbed run makes
        std::optional<Step> step =
            take_step(state, now, batch, at(size.taken), optimised, backend, options, is_rejected);
        if (step) return step;
        if (++n_refusals == most_refusals)
            return try_step(state, batch, optimised.targets, all_but(size.taken, batch, state, scores), backend,
                            options);
    }
    return std::nullopt;
}

/// A batch that takes the state nearer to the fitted surface, whatever the images say of it.
/// @return nullopt if nothing can be split
std::optional<Step> approach(const RefinableMesh& state, PhotoBackend& backend, const RefinementScene& scene,
                             const RefineOptions& options) {
    SurfaceMeter meter(
        scene.fitted);  // a new one each time: what it remembered, a run that goes on here could not know
    const MeasuredMesh measured = measure(state, meter);
    const std::vector<char> none_rejected(measured.faces.size(), 0);
    const std::vector<double> scores = split_scores(measured.mesh, distance_scores(measured),
                                                    scene.guessed.vertices(measured.mesh), none_rejected, options);
    const std::vector<std::int32_t> batch = select_batch(state, scores, batch_size(state.n_vertices(), options).taken);
    if (batch.empty()) return std::nullopt;
    const BatchTargets targets = fit_batch(state, batch, meter);
    Step step{state, {}, {}};
    step.records =
        emit_batch(step.state, batch, targets, {}, {.bit_price = options.bit_price * gain_of_a_bit(measured)});
    step.distortion = measure_state(backend, step.state, options.samples_per_px);
    return step;
}

}  // namespace

StateDistortion measure_state(PhotoBackend& backend, const RefinableMesh& state, double samples_per_px) {
    const Mesh mesh = state.to_mesh();
    const SurfaceView surface(mesh);
    backend.set_surface(surface, 0, samples_per_px);
    const std::vector<TriangleQuery> queries = whole_surface(surface);
    StateDistortion result;
    result.terms = backend.terms(queries, corner_normals(surface));
    result.pixel_sizes.reserve(queries.size());
    for (const TriangleQuery& query : queries) result.pixel_sizes.push_back(backend.pixel_size(query.face));
    std::vector<TriangleDistortion> distortions;
    distortions.reserve(result.terms.size());
    for (const TriangleTerms& t : result.terms) {
        distortions.push_back(t.distortion);
        if (t.distortion.n_samples > 0)
            result.point.max = std::max(result.point.max, t.distortion.phi / t.distortion.n_samples);
    }
    result.point.mean = surface_distortion(distortions);
    return result;
}

std::vector<CurvePoint> refine(RefinableMesh& state, PhotoBackend& backend, const RefinementScene& scene,
                               const RefineOptions& options, ModelSink& sink,
                               const std::function<void(const CurvePoint&)>& progress, const std::stop_token& stop,
                               std::vector<char>* rejected) {
    StateDistortion now = measure_state(backend, state, options.samples_per_px);
    std::vector<CurvePoint> curve{{state.n_vertices(), now.point.mean}};
    std::vector<char> none_rejected;
    std::vector<char>& is_rejected = rejected ? *rejected : none_rejected;
    while (state.n_vertices() + 3 <= options.n_vertices && !stop.stop_requested()) {
        is_rejected.resize(at(state.n_faces()), 0);
        const bool is_credible = options.by_area || now.point.mean <= options.most_credible_psi;
        std::optional<Step> step = is_credible ? follow_images(state, now, backend, scene, options, stop, is_rejected)
                                               : approach(state, backend, scene, options);
        if (!step || step->records.empty()) break;
        const std::int32_t n_before = state.n_vertices();
        state = std::move(step->state);
        now = std::move(step->distortion);
        curve.push_back({state.n_vertices(), now.point.mean});
        std::vector<std::int32_t> added(at(state.n_vertices() - n_before));
        std::iota(added.begin(), added.end(), n_before);
        const Mesh refined = state.to_mesh();
        sink.batch(step->records, state,
                   vertex_colours(scene.images, refined, vertex_spacing(refined, options.n_vertices), added),
                   now.point);
        if (progress) progress(curve.back());
    }
    return curve;
}

}  // namespace anyrate
