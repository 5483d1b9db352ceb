#include "core/reconstruction/refine.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/reconstruction/batch_selection.h"
#include "core/reconstruction/optimise_surface.h"
#include "core/reconstruction/vertex_colours.h"

namespace anyrate {
namespace {

/// No vertex moves further in one split than about half an edge (edge / 80 is a step): what wants to go on can do so in
/// a later batch, and a needle's erratic normal cannot throw a spike.
constexpr double largest_scalar = 40;

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

std::vector<double> split_scores(const Mesh& mesh, std::span<const TriangleTerms> terms,
                                 std::span<const char> is_guessed, const RefineOptions& options) {
    const std::size_t n = mesh.triangles.size();
    std::vector<double> areas(n), scores(n);
    const auto is_guess = [&](std::size_t f) {
        return std::ranges::any_of(mesh.triangles[f], [&](std::int32_t v) { return is_guessed[at(v)] != 0; });
    };
    for (std::size_t f = 0; f < n; ++f) {
        areas[f] = face_area(mesh, mesh.triangles[f]);
        scores[f] = options.by_area || is_guess(f) ? 0.0 : expected_gain(terms[f]);
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

/// Where the optimisation wants the vertices of a batch: old ones by number, new ones by their place in the batch.
struct Targets {
    std::vector<Vec3> old_vertices;                                ///< world units, all vertices before the batch
    std::vector<std::optional<std::array<Vec3, 3>>> new_vertices;  ///< per face of the batch
};

/// Splits the batch on a copy of the state, moves the nine vertices of each split to where the images agree most.
Targets optimise_batch(const RefinableMesh& state, std::span<const std::int32_t> batch, PhotoBackend& backend,
                       Silhouettes& silhouettes, const GuessedSurface& guessed, const RefineOptions& options,
                       const std::stop_token& stop) {
    RefinableMesh trial = state;
    std::vector<std::int32_t> first_new(batch.size(), -1), active;
    for (std::size_t k = 0; k < batch.size(); ++k) {
        const auto site = trial.split_site(batch[k]);
        if (!site) continue;  // a flip of an earlier split changed the face
        first_new[k] = trial.n_vertices();
        active.insert(active.end(), site->begin(), site->end());
        trial.split(batch[k], [](const ScalarSite&) { return 0; });
        for (std::int32_t i = 0; i < 3; ++i) active.push_back(first_new[k] + i);
    }
    std::sort(active.begin(), active.end());
    active.erase(std::unique(active.begin(), active.end()), active.end());

    Mesh mesh = trial.to_mesh();
    const std::vector<char> is_guessed = guessed.vertices(mesh);
    std::erase_if(active, [&](std::int32_t v) { return is_guessed[at(v)] != 0; });
    OptimiseOptions optimise;
    optimise.rounds = 2;
    optimise.steps_per_round = 3;
    optimise.tangential = 0;  // the operation smooths tangentially by itself
    optimise.samples_per_px = options.samples_per_px;
    if (!active.empty())
        optimise_surface(backend, silhouettes, mesh.vertices, mesh.triangles, active, is_guessed, optimise, stop);

    Targets targets;
    targets.old_vertices.assign(mesh.vertices.begin(), mesh.vertices.begin() + state.n_vertices());
    targets.new_vertices.resize(batch.size());
    for (std::size_t k = 0; k < batch.size(); ++k)
        if (const std::int32_t v = first_new[k]; v >= 0)
            targets.new_vertices[k] = {mesh.vertices[at(v)], mesh.vertices[at(v + 1)], mesh.vertices[at(v + 2)]};
    return targets;
}

/// Splits the batch for good, each vertex going as near to its target as its scalar allows.
std::vector<SplitRecord> emit_batch(RefinableMesh& state, std::span<const std::int32_t> batch, const Targets& targets,
                                    double dead_zone) {
    std::vector<SplitRecord> records;
    records.reserve(batch.size());
    const Grid grid = state.grid();
    for (std::size_t k = 0; k < batch.size(); ++k) {
        if (!state.split_site(batch[k])) continue;
        records.push_back(state.split(batch[k], [&](const ScalarSite& site) -> std::int32_t {
            const bool is_new = site.slot < 3;
            if (is_new && !targets.new_vertices[k]) return 0;
            const Vec3& target =
                is_new ? (*targets.new_vertices[k])[at(site.slot)] : targets.old_vertices[at(site.vertex)];
            const Vec3 target_in_grid = (target - grid.origin) / grid.unit;
            const double steps = (target_in_grid - site.position).dot(site.normal) / site.step;
            if (!is_new && std::abs(steps) < dead_zone) return 0;
            return static_cast<std::int32_t>(std::lround(std::clamp(steps, -largest_scalar, largest_scalar)));
        }));
    }
    return records;
}

int batch_size(int n_vertices, const RefineOptions& options) {
    const int wanted = (options.n_vertices - n_vertices) / 3;
    const int grown = std::max(1, static_cast<int>(std::lround(options.growth * n_vertices / 3)));
    // A last crumb joins its predecessor.
    return wanted < grown + grown / 3 ? wanted : grown;
}

}  // namespace

StateDistortion measure_state(PhotoBackend& backend, const RefinableMesh& state, double samples_per_px) {
    const Mesh mesh = state.to_mesh();
    const SurfaceView surface(mesh);
    const OneRings rings(surface);
    const std::vector<Vec3> normals = vertex_normals(surface, rings);
    backend.set_surface(surface, 0, samples_per_px);
    std::vector<TriangleQuery> queries(mesh.triangles.size());
    std::vector<std::array<Vec3, 3>> directions(mesh.triangles.size());
    for (std::size_t f = 0; f < queries.size(); ++f) {
        queries[f].face = static_cast<std::int32_t>(f);
        for (std::size_t k = 0; k < 3; ++k) {
            queries[f].corners[k] = mesh.vertices[at(mesh.triangles[f][k])];
            directions[f][k] = normals[at(mesh.triangles[f][k])];
        }
    }
    StateDistortion result;
    result.terms = backend.terms(queries, directions);
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

std::vector<CurvePoint> refine(RefinableMesh& state, PhotoBackend& backend, Silhouettes& silhouettes,
                               const PhotoImages& images, const GuessedSurface& guessed, const RefineOptions& options,
                               ModelSink& sink, const std::function<void(const CurvePoint&)>& progress,
                               const std::stop_token& stop) {
    StateDistortion now = measure_state(backend, state, options.samples_per_px);
    std::vector<CurvePoint> curve{{state.n_vertices(), now.point.mean}};
    while (state.n_vertices() + 3 <= options.n_vertices && !stop.stop_requested()) {
        const Mesh mesh = state.to_mesh();
        const std::vector<double> scores = split_scores(mesh, now.terms, guessed.vertices(mesh), options);
        const std::vector<std::int32_t> batch = select_batch(state, scores, batch_size(state.n_vertices(), options));
        if (batch.empty()) break;
        const Targets targets = optimise_batch(state, batch, backend, silhouettes, guessed, options, stop);
        const std::int32_t n_before = state.n_vertices();
        const std::vector<SplitRecord> records = emit_batch(state, batch, targets, options.dead_zone);
        if (records.empty()) break;

        now = measure_state(backend, state, options.samples_per_px);
        curve.push_back({state.n_vertices(), now.point.mean});
        std::vector<std::int32_t> added(static_cast<std::size_t>(state.n_vertices() - n_before));
        std::iota(added.begin(), added.end(), n_before);
        const Mesh refined = state.to_mesh();
        sink.batch(records, state, vertex_colours(images, refined, added), now.point);
        if (progress) progress(curve.back());
    }
    return curve;
}

}  // namespace anyrate
