#include "core/reconstruction/refinement_step.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace anyrate {
namespace {

constexpr int fewest_tried = 40;  ///< splits of a batch

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

double face_area(const Mesh& mesh, const Triangle& t) {
    const Vec3& a = mesh.vertices[at(t[0])];
    return 0.5 * (mesh.vertices[at(t[1])] - a).cross(mesh.vertices[at(t[2])] - a).norm();
}

DistortionPoint point_of(std::span<const TriangleDistortion> distortions) {
    DistortionPoint point{surface_distortion(distortions), 0};
    for (const TriangleDistortion& face : distortions)
        if (face.n_samples > 0) point.max = std::max(point.max, face.phi / face.n_samples);
    return point;
}

}  // namespace

BatchSize batch_size(int n_vertices, double growth, const RefineOptions& options) {
    // Whole batches, all of the same growth: a crumb at the end would cost a whole measurement.
    const double to_grow = static_cast<double>(options.n_vertices) / n_vertices;
    const double n_batches = std::max(1.0, std::round(std::log(to_grow) / std::log1p(growth)));
    const double even_growth = std::pow(to_grow, 1 / n_batches) - 1;
    const int grown = std::max(1, static_cast<int>(std::lround(even_growth * n_vertices / 3)));
    const int taken = n_batches > 1 ? grown : (options.n_vertices - n_vertices) / 3;
    if (options.by_area) return {taken, taken};
    // The images bear some out better than was expected, others not at all. A last batch that takes few may leave a
    // crumb: it tries twice as many.
    const int usual = static_cast<int>(growth * n_vertices / 3);
    const int tried = taken < usual ? std::min(2 * taken, usual) : taken;
    return {std::max(fewest_tried, tried), taken};
}

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

StateDistortion measure_state(PhotoBackend& backend, const RefinableMesh& state, double samples_per_px) {
    const Mesh mesh = state.to_mesh();
    const SurfaceView surface(mesh);
    backend.set_surface(surface, 0, samples_per_px);
    const std::vector<TriangleQuery> queries = whole_surface(surface);
    StateDistortion result;
    result.terms = backend.terms(queries, corner_normals(surface));
    std::vector<TriangleDistortion> distortions;
    distortions.reserve(result.terms.size());
    for (const TriangleTerms& t : result.terms) distortions.push_back(t.distortion);
    result.point = point_of(distortions);
    return result;
}

DistortionPoint current_distortion(PhotoBackend& backend, const SurfaceView& surface) {
    return point_of(backend.distortions(whole_surface(surface)));
}

StateDistortion measure_without_terms(PhotoBackend& backend, const RefinableMesh& state, double samples_per_px) {
    const Mesh mesh = state.to_mesh();
    const SurfaceView surface(mesh);
    backend.set_surface(surface, 0, samples_per_px);
    return {current_distortion(backend, surface), {}};
}

}  // namespace anyrate
