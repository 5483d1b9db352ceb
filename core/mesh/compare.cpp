#include "core/mesh/compare.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/error.h"
#include "core/mesh/bounds.h"
#include "core/mesh/nearest_surface.h"
#include "core/mesh/surface_samples.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

using Predicate = std::function<bool(const Vec3&)>;

constexpr double left_out = -1;

/// For each point its distance to the surface, or `left_out` where the reference is not seen; `is_reference` tells
/// whether the point itself or its nearest point lies on the reference.
std::vector<double> distances(const std::vector<Vec3>& points, const Mesh& surface, bool is_reference,
                              const Predicate& seen) {
    const NearestSurface nearest(surface);
    std::vector<double> result(points.size());
    parallel_for(points.size(), [&](std::size_t i) {
        const NearestSurface::Hit hit = nearest.nearest(points[i]);
        const bool is_in = seen(is_reference ? points[i] : hit.point);
        result[i] = is_in ? std::sqrt(hit.squared_distance) : left_out;
    });
    std::erase(result, left_out);
    return result;
}

double mean_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// The smallest value below which nine tenths of the weight lie, both sets weighing the same. Both are sorted.
double pooled_p90(const std::vector<double>& a, const std::vector<double>& b) {
    const double weight_a = 0.5 / static_cast<double>(a.size()), weight_b = 0.5 / static_cast<double>(b.size());
    std::size_t i = 0, j = 0;
    double weight = 0, value = 0;
    while (weight < 0.9 && (i < a.size() || j < b.size())) {
        const bool takes_a = j == b.size() || (i < a.size() && a[i] <= b[j]);
        value = takes_a ? a[i++] : b[j++];
        weight += takes_a ? weight_a : weight_b;
    }
    return value;
}

}  // namespace

SurfaceDistance compare_surfaces(const Mesh& mesh, const Mesh& reference, const CompareOptions& options) {
    return compare_surfaces(
        mesh, reference, [](const Vec3&) { return true; }, options);
}

SurfaceDistance compare_surfaces(const Mesh& mesh, const Mesh& reference, const Predicate& seen,
                                 const CompareOptions& options) {
    const std::vector<Vec3> on_mesh = sample_surface(mesh, options.n_samples, options.seed).points;
    const std::vector<Vec3> on_reference = sample_surface(reference, options.n_samples, options.seed + 1).points;
    std::vector<double> accuracy = distances(on_mesh, reference, false, seen);
    std::vector<double> completeness = distances(on_reference, mesh, true, seen);
    if (accuracy.empty() || completeness.empty()) throw InputError("compare: no point of the reference is seen");
    const double diagonal = bounding_box(reference).diagonal().norm();
    SurfaceDistance distance;
    distance.accuracy = mean_of(accuracy) / diagonal;
    distance.completeness = mean_of(completeness) / diagonal;
    distance.mean = (distance.accuracy + distance.completeness) / 2;
    std::ranges::sort(accuracy);
    std::ranges::sort(completeness);
    distance.p90 = pooled_p90(accuracy, completeness) / diagonal;
    distance.hausdorff = std::max(accuracy.back(), completeness.back()) / diagonal;
    return distance;
}

}  // namespace anyrate
