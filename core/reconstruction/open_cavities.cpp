#include "core/reconstruction/open_cavities.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/LU>

#include "core/parallel.h"
#include "core/reconstruction/confirmed_depth.h"
#include "core/reconstruction/fuse_points.h"
#include "core/reconstruction/point_grid.h"

namespace anyrate {
namespace {

enum class Sight { nothing, surface, through };

// What a view says of a point: that it is on the surface, or that everything known around there lies further away, by
// more than the margin.
Sight look_at(const DepthMap& map, const Vec3& point, double margin_px) {
    const Vec3 x = map.P * point.homogeneous();
    if (!(x.z() > 0)) return Sight::nothing;
    const double u = x.x() / x.z(), v = x.y() / x.z();
    const auto& known = map.inverse_depth;
    if (!(u >= 0 && v >= 0 && u < known.width - 1 && v < known.height - 1)) return Sight::nothing;
    const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
    int n_surface = 0, n_through = 0;
    for (int i = 0; i < 4; ++i) {
        const double inverse_depth = known(x0 + (i & 1), y0 + (i >> 1));
        if (!(inverse_depth > 0)) continue;
        const double behind_px = (1.0 / x.z() - inverse_depth) / map.step;
        n_surface += std::abs(behind_px) <= margin_px;
        n_through += behind_px > margin_px;
    }
    return n_surface > 0 ? Sight::surface : n_through == 4 ? Sight::through : Sight::nothing;
}

// A thin part may vanish before its background in some views, never in most: those that find it outvote twice as many.
std::vector<OrientedPoint> without_seen_through(std::span<const OrientedPoint> points, std::span<const DepthMap> maps,
                                                const CavityOptions& options) {
    std::vector<char> floats(points.size());
    parallel_for(points.size(), [&](std::size_t p) {
        int n_surface = 0, n_through = 0;
        for (const DepthMap& map : maps) {
            const Sight sight = look_at(map, points[p].position, options.margin_px);
            n_surface += sight == Sight::surface;
            n_through += sight == Sight::through;
        }
        floats[p] = n_through >= options.n_views && n_through > 2 * n_surface;
    });
    std::vector<OrientedPoint> kept;
    for (std::size_t p = 0; p < points.size(); ++p)
        if (floats[p] == 0) kept.push_back(points[p]);
    return kept;
}

// ---- lengths of the world that correspond to pixels of the sweep

struct Scale {
    double pixel = 0;      // edge of a pixel's footprint
    double disparity = 0;  // change of depth that is a pixel of disparity
};

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

std::optional<Scale> scale_at(const Vec3& point, std::span<const DepthMap> maps) {
    std::vector<double> pixel, disparity;
    for (const DepthMap& map : maps) {
        const double depth = (map.P * point.homogeneous()).z();
        if (!(map.step > 0) || !(depth > 0)) continue;
        // The determinant is the product of the two focal lengths.
        pixel.push_back(depth / std::sqrt(std::abs(map.P.leftCols<3>().determinant())));
        disparity.push_back(map.step * depth * depth);
    }
    if (pixel.empty()) return std::nullopt;
    return Scale{median(std::move(pixel)), median(std::move(disparity))};
}

// What all maps show, without what some of them see through.
std::vector<OrientedPoint> surface_seen(std::span<const DepthMap> maps, const CavityOptions& options) {
    std::vector<std::vector<OrientedPoint>> of_map(maps.size());
    parallel_for(
        maps.size(), [&](std::size_t i) { of_map[i] = without_seen_through(surface_points(maps[i]), maps, options); },
        1);
    std::vector<OrientedPoint> seen;
    for (const auto& part : of_map) seen.insert(seen.end(), part.begin(), part.end());
    return seen;
}

}  // namespace

std::vector<OrientedPoint> open_cavities(const VisualHull& hull, std::span<const DepthMap> maps,
                                         const CavityOptions& options) {
    const auto scale = scale_at(0.5 * (hull.lower + hull.upper), maps);
    if (!scale) return hull.points;
    std::vector<OrientedPoint> points = without_seen_through(hull.points, maps, options);
    if (points.size() == hull.points.size()) return points;

    const std::vector<OrientedPoint> seen = fuse_points(surface_seen(maps, options), scale->pixel, hull.cell);
    const PointGrid kept(points, options.margin_px * scale->disparity);
    std::vector<char> is_new(seen.size());
    parallel_for(seen.size(), [&](std::size_t p) {
        is_new[p] = 1;
        kept.for_each_near(seen[p], [&](const OrientedPoint&) { return is_new[p] = 0, false; });
    });
    for (std::size_t p = 0; p < seen.size(); ++p)
        if (is_new[p] != 0) points.push_back(seen[p]);
    return points;
}

}  // namespace anyrate
