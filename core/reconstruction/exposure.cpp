#include "core/reconstruction/exposure.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/parallel.h"
#include "core/reconstruction/inverse_depth.h"

namespace anyrate {
namespace {

constexpr int sampled_level = 2;  // of the pyramid: fine texture and small errors of the surface average out
constexpr std::size_t most_points = 20'000;
constexpr int n_iterations = 40;
constexpr double least_cos = 0.5;    // of the angle under which a view sees a point
constexpr double hidden_px = 3.0;    // behind the nearest surface, in pixels of the level sampled
constexpr double least_gain = 1.02;  // that is worth the rounding of all colours; twice what good views measure
constexpr float darkest = 12, brightest = 243;  // of 255: beyond, a channel says nothing of its gain

// One channel of one point as a view shows it.
struct Observation {
    std::int32_t view, point;
    double log_value;
};

// Every observation of a channel, in the order of the views.
using Observations = std::vector<Observation>;

std::array<Observations, 3> observe(const PhotoView& view, std::int32_t index, const SurfaceView& surface,
                                    const std::vector<Vec3>& normals, std::size_t stride) {
    std::array<Observations, 3> seen;
    const PhotoLevel& level = view.levels[std::min<std::size_t>(sampled_level, view.levels.size() - 1)];
    const Image<float> inverse_depth = render_inverse_depth(level, surface);
    const double px = static_cast<double>(view.levels.front().width) / (view.focal_px * level.width);
    for (std::size_t v = 0; v < surface.vertices.size(); v += stride) {
        const Vec3& p = surface.vertices[v];
        if (normals[v].dot((view.centre - p).normalized()) < least_cos) continue;
        const Vec3 x = level.P * p.homogeneous();
        ColourSample colour;
        if (!(x.z() > 0) || !sample_colour(level, x.x() / x.z(), x.y() / x.z(), colour)) continue;
        const float nearest =
            inverse_depth(static_cast<int>(x.x() / x.z() + 0.5), static_cast<int>(x.y() / x.z() + 0.5));
        if (x.z() * nearest > 1 + hidden_px * px) continue;
        for (std::size_t k = 0; k < 3; ++k)
            if (colour.c[k] > darkest && colour.c[k] < brightest)
                seen[k].push_back({index, static_cast<std::int32_t>(v / stride), std::log(colour.c[k])});
    }
    return seen;
}

double median(std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

std::vector<double> solve_log_gains(const Observations& observations, std::size_t n_views, std::size_t n_points) {
    std::vector<double> gains(n_views, 0.0), points(n_points);
    std::vector<int> n_seen(n_points, 0);
    for (const Observation& o : observations) ++n_seen[static_cast<std::size_t>(o.point)];
    std::vector<double> residuals;
    for (int iteration = 0; iteration < n_iterations; ++iteration) {
        std::fill(points.begin(), points.end(), 0.0);
        for (const Observation& o : observations)
            points[static_cast<std::size_t>(o.point)] += o.log_value - gains[static_cast<std::size_t>(o.view)];
        for (std::size_t p = 0; p < n_points; ++p) points[p] /= std::max(n_seen[p], 1);
        double mean = 0;
        std::vector<std::size_t> shared;  // views that show what another one shows
        for (auto begin = observations.begin(); begin != observations.end();) {
            const auto view = static_cast<std::size_t>(begin->view);
            residuals.clear();
            for (; begin != observations.end() && static_cast<std::size_t>(begin->view) == view; ++begin)
                if (n_seen[static_cast<std::size_t>(begin->point)] > 1)
                    residuals.push_back(begin->log_value - points[static_cast<std::size_t>(begin->point)]);
            if (residuals.empty()) continue;
            gains[view] = median(residuals);
            mean += gains[view];
            shared.push_back(view);
        }
        for (const std::size_t view : shared) gains[view] -= mean / static_cast<double>(shared.size());
    }
    return gains;
}

}  // namespace

std::vector<Gains> estimate_gains(const PhotoImages& images, const SurfaceView& surface) {
    const std::vector<Vec3> normals = vertex_normals(surface, OneRings(surface));
    const std::size_t stride = surface.vertices.size() / most_points + 1;
    std::vector<std::array<Observations, 3>> by_view(images.views.size());
    parallel_for(
        by_view.size(),
        [&](std::size_t i) {
            by_view[i] = observe(images.views[i], static_cast<std::int32_t>(i), surface, normals, stride);
        },
        1);
    std::vector<Gains> gains(images.views.size());
    parallel_for(
        3,
        [&](std::size_t k) {
            Observations all;
            for (const auto& seen : by_view) all.insert(all.end(), seen[k].begin(), seen[k].end());
            const auto logs = solve_log_gains(all, by_view.size(), surface.vertices.size() / stride + 1);
            for (std::size_t i = 0; i < gains.size(); ++i) gains[i][k] = std::exp(logs[i]);
        },
        1);
    return gains;
}

std::vector<Gains> even_out_exposure(PhotoImages& images, const SurfaceView& surface) {
    const std::vector<Gains> gains = estimate_gains(images, surface);
    const auto is_even = [](double gain) { return std::max(gain, 1 / gain) < least_gain; };
    if (std::ranges::all_of(gains, [&](const Gains& g) { return std::ranges::all_of(g, is_even); })) return {};
    divide_by_gains(images, gains);
    return gains;
}

void divide_by_gains(PhotoImages& images, std::span<const Gains> gains) {
    parallel_for(
        images.views.size(),
        [&](std::size_t i) {
            std::array<std::array<std::uint8_t, 256>, 3> divided;
            for (std::size_t k = 0; k < 3; ++k)
                for (std::size_t c = 0; c < 256; ++c)
                    divided[k][c] =
                        static_cast<std::uint8_t>(std::min(static_cast<double>(c) / gains[i][k] + 0.5, 255.0));
            for (PhotoLevel& level : images.views[i].levels)
                for (std::size_t p = 0; p < level.rgba.size(); p += 4)
                    for (std::size_t k = 0; k < 3; ++k) level.rgba[p + k] = divided[k][level.rgba[p + k]];
        },
        1);
}

}  // namespace anyrate
