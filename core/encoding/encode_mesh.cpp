#include "core/encoding/encode_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "core/encoding/closed_surface.h"
#include "core/encoding/surface_colours.h"
#include "core/error.h"
#include "core/mesh/coarse_fit.h"
#include "core/mesh/self_intersections.h"
#include "core/mesh/surface_meter.h"
#include "core/mesh/triangle_shape.h"
#include "core/mesh/true_surface.h"
#include "core/progressive/base_on_grid.h"
#include "core/progressive/surface_approach.h"

namespace anyrate {
namespace {

constexpr int smallest_count = 100, largest_count = 1'000'000;
constexpr int samples_per_vertex = 6;  ///< of the true surface, for each of the finest mesh
constexpr int fewest_samples = 60'000, most_samples = 2'000'000;
constexpr int fewest_splits = 128;  ///< of a batch: a packet's tables cost their bytes however few use them

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

void require_counts(const EncodeMeshOptions& options) {
    const auto require = [](const std::string& name, int count, int least) {
        if (count < least || count > largest_count)
            throw InputError(name + ": expected a number from " + std::to_string(least) + " to " +
                             std::to_string(largest_count) + ", got " + std::to_string(count));
    };
    require("vertices", options.n_vertices, smallest_count);
    require("coarse", options.n_coarse, smallest_count);
    require("vertices, no fewer than coarse", options.n_vertices, options.n_coarse);
}

/// In squared world units.
DistortionPoint distortion_of(const MeasuredMesh& now) {
    DistortionPoint point;
    double area = 0;
    for (const FaceDistance& face : now.faces) {
        area += face.area;
        if (face.area > 0) point.max = std::max(point.max, face.squared / face.area);
    }
    point.mean = squared_distance(now) / area;
    return point;
}

DistortionPoint in_grid_units(const DistortionPoint& point, const Grid& grid) {
    const double unit2 = grid.unit * grid.unit;
    return {point.mean / unit2, point.max / unit2};
}

/// What a split of each face promises; 0 for a face that is not to be split.
std::vector<double> split_scores(const MeasuredMesh& now, std::span<const char> is_rejected, double smallest_area) {
    const std::size_t n = now.faces.size();
    std::vector<double> areas(n), scores = distance_scores(now);
    for (std::size_t f = 0; f < n; ++f) {
        const auto& [a, b, c] = now.mesh.triangles[f];
        const auto& v = now.mesh.vertices;
        areas[f] = 0.5 * twice_area_vector(v[at(a)], v[at(b)], v[at(c)]).norm();
        if (is_rejected[f] != 0) scores[f] = 0;
    }
    const double mean_area = std::accumulate(areas.begin(), areas.end(), 0.0) / static_cast<double>(n);
    const double mean_score = std::accumulate(scores.begin(), scores.end(), 0.0) / static_cast<double>(n);
    // Area breaks the ties among faces without an error, so that the count is met on a plane surface too.
    const double per_area = mean_score > 0 ? 1e-3 * mean_score / mean_area : 1.0;
    for (std::size_t f = 0; f < n; ++f)
        scores[f] = areas[f] < smallest_area * mean_area ? 0.0 : scores[f] + per_area * areas[f];
    return scores;
}

int splits_of_batch(int n_vertices, const EncodeMeshOptions& options) {
    const int wanted = (options.n_vertices - n_vertices) / 3;
    const int grown = std::max(fewest_splits, static_cast<int>(std::lround(options.growth * n_vertices / 3)));
    return wanted < grown + grown / 3 ? wanted : grown;  // a last crumb joins its predecessor
}

}  // namespace

EncodeEnd encode_mesh(const Mesh& mesh, const EncodeMeshOptions& options, ModelSink& sink,
                      const std::function<void(const EncodeProgress&)>& progress, std::stop_token stop) {
    require_counts(options);
    require_closed_surface(mesh, options.name);
    if (progress) progress({});
    const TrueSurface surface(mesh, std::clamp(samples_per_vertex * options.n_vertices, fewest_samples, most_samples));
    if (stop.stop_requested()) return EncodeEnd::before_the_base;
    SurfaceMeter base_meter(surface);
    const bool may_meet = !self_intersections(mesh).empty();
    const Mesh coarse = fit_coarse_mesh(mesh, options.n_coarse, base_meter, may_meet);
    if (stop.stop_requested()) return EncodeEnd::before_the_base;

    // From here on only the decoded integer state counts.
    Grid grid = make_grid(mesh, options.n_vertices);
    grid.base_shift = base_shift(coarse, grid);
    const RefinementRules rules{.step_ratio = options.step_ratio};
    RefinableMesh state(sink.start(grid, rules, to_base(coarse, grid)), grid, rules);
    SurfaceMeter meter(surface);
    MeasuredMesh now = measure(state, meter);
    const auto tell = [&] {
        if (progress) progress({state.n_vertices(), std::sqrt(distortion_of(now).mean)});
    };
    sink.base_attributes(surface_colours(mesh, surface.nearest, now.mesh.vertices),
                         in_grid_units(distortion_of(now), grid));
    tell();
    std::vector<char> is_rejected;
    while (state.n_vertices() + 3 <= options.n_vertices && !stop.stop_requested()) {
        const int n_before = state.n_vertices();
        is_rejected.resize(at(state.n_faces()), 0);
        const auto [records, rejected] = approach(
            state, now, split_scores(now, is_rejected, options.smallest_area), splits_of_batch(n_before, options),
            meter, {.rounding = {.bit_price = options.bit_price * gain_of_a_bit(now)}, .may_meet = may_meet});
        if (records.empty()) break;
        for (const std::int32_t face : rejected) is_rejected[at(face)] = 1;
        now = measure(state, meter);
        const auto added = std::span(now.mesh.vertices).subspan(at(n_before));
        sink.batch(records, state, surface_colours(mesh, surface.nearest, added),
                   in_grid_units(distortion_of(now), grid));
        tell();
    }
    sink.finish();
    return stop.stop_requested() ? EncodeEnd::stopped : EncodeEnd::done;
}

}  // namespace anyrate
