#include "core/reconstruction/open_cavities.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "core/parallel.h"
#include "core/reconstruction/confirmed_depth.h"

namespace anyrate {
namespace {

// Whether the view sees past the point: everything it knows around there lies further away, by more than the margin.
bool sees_through(const DepthMap& map, const Vec3& point, double margin_px) {
    const Vec3 x = map.P * point.homogeneous();
    if (!(x.z() > 0)) return false;
    const double u = x.x() / x.z(), v = x.y() / x.z();
    const auto& known = map.inverse_depth;
    if (!(u >= 0 && v >= 0 && u < known.width - 1 && v < known.height - 1)) return false;
    const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
    for (int i = 0; i < 4; ++i) {
        const double inverse_depth = known(x0 + (i & 1), y0 + (i >> 1));
        if (!(inverse_depth > 0) || 1.0 / x.z() - inverse_depth < margin_px * map.step) return false;
    }
    return true;
}

std::vector<OrientedPoint> without_seen_through(const std::vector<OrientedPoint>& points,
                                                std::span<const DepthMap> maps, const CavityOptions& options) {
    std::vector<char> floats(points.size());
    parallel_for(points.size(), [&](std::size_t p) {
        int n_views = 0;
        for (std::size_t i = 0; i < maps.size() && n_views < options.n_views; ++i)
            n_views += sees_through(maps[i], points[p].position, options.margin_px);
        floats[p] = n_views >= options.n_views;
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
        pixel.push_back(depth / std::cbrt(std::abs(map.P.leftCols<3>().determinant())));
        disparity.push_back(map.step * depth * depth);
    }
    if (pixel.empty()) return std::nullopt;
    return Scale{median(std::move(pixel)), median(std::move(disparity))};
}

// ---- points in cubes of space

// (z, y, x), so that the cubes of a row follow each other.
using Cube = std::array<std::int32_t, 3>;

// Points in the order of the cubes they lie in.
class PointGrid {
public:
    PointGrid(std::span<const OrientedPoint> points, double edge) : points_(points), edge_(edge) {
        places_.reserve(points.size());
        for (std::size_t p = 0; p < points.size(); ++p) places_.push_back({cube_of(points[p].position), p});
        std::sort(places_.begin(), places_.end());
    }

    // Calls visit(points) for every cube that has any.
    template <class Visit>
    void for_each_cube(const Visit& visit) const {
        std::vector<OrientedPoint> in_cube;
        for (std::size_t i = 0; i < places_.size(); ++i) {
            in_cube.push_back(points_[places_[i].second]);
            if (i + 1 < places_.size() && places_[i + 1].first == places_[i].first) continue;
            visit(in_cube);
            in_cube.clear();
        }
    }

    // Whether a point that faces the same way lies within the edge of a cube.
    bool has_near(const OrientedPoint& point) const {
        const auto is_near = [&](const OrientedPoint& other) {
            return (other.position - point.position).squaredNorm() < edge_ * edge_ &&
                   other.normal.dot(point.normal) > 0;
        };
        const Cube middle = cube_of(point.position);
        for (std::int32_t row = 0; row < 9; ++row) {
            const Cube first = {middle[0] + row / 3 - 1, middle[1] + row % 3 - 1, middle[2] - 1};
            const Cube last = {first[0], first[1], middle[2] + 1};
            for (auto place = std::lower_bound(places_.begin(), places_.end(), Place{first, 0});
                 place != places_.end() && place->first <= last; ++place)
                if (is_near(points_[place->second])) return true;
        }
        return false;
    }

private:
    using Place = std::pair<Cube, std::size_t>;

    Cube cube_of(const Vec3& point) const {
        const Vec3 p = ((point - points_.front().position) / edge_).array().floor();
        return {static_cast<std::int32_t>(p.z()), static_cast<std::int32_t>(p.y()), static_cast<std::int32_t>(p.x())};
    }

    std::span<const OrientedPoint> points_;
    double edge_;
    std::vector<Place> places_;
};

// The mean point of every cube; two where the two sides of a thin wall share one.
std::vector<OrientedPoint> thin_out(const std::vector<OrientedPoint>& points, double edge) {
    std::vector<OrientedPoint> means;
    if (points.empty()) return means;
    PointGrid(points, edge).for_each_cube([&](const std::vector<OrientedPoint>& in_cube) {
        for (const bool front : {true, false}) {
            OrientedPoint sum{Vec3::Zero(), Vec3::Zero(), 0.0};
            for (const OrientedPoint& point : in_cube) {
                if ((point.normal.dot(in_cube.front().normal) > 0) != front) continue;
                sum.position += point.position;
                sum.normal += point.normal;
                sum.area += 1.0;
            }
            if (!(sum.normal.norm() > 0)) continue;
            OrientedPoint mean{sum.position / sum.area, sum.normal.normalized(), 0.0};
            // A surface element cuts the cubes of a grid at this rate.
            mean.area = edge * edge / mean.normal.lpNorm<1>();
            means.push_back(mean);
        }
    });
    return means;
}

// A point as a square patch of n x n points of its tangent plane.
void add_patch(const OrientedPoint& point, double edge, int n, std::vector<OrientedPoint>& points) {
    const Vec3 across = point.normal.unitOrthogonal(), along = point.normal.cross(across);
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const double u = (i + 0.5) / n - 0.5, v = (j + 0.5) / n - 0.5;
            points.push_back({point.position + edge * (u * across + v * along), point.normal, point.area / (n * n)});
        }
}

}  // namespace

std::vector<OrientedPoint> open_cavities(const VisualHull& hull, std::span<const DepthMap> maps,
                                         const CavityOptions& options) {
    const auto scale = scale_at(0.5 * (hull.lower + hull.upper), maps);
    if (!scale) return hull.points;
    std::vector<OrientedPoint> points = without_seen_through(hull.points, maps, options);
    if (points.size() == hull.points.size()) return points;

    std::vector<std::vector<OrientedPoint>> of_map(maps.size());
    parallel_for(
        maps.size(), [&](std::size_t i) { of_map[i] = surface_points(maps[i]); }, 1);
    std::vector<OrientedPoint> seen;
    for (const auto& part : of_map) seen.insert(seen.end(), part.begin(), part.end());
    seen = thin_out(seen, scale->pixel);

    const PointGrid kept(points, options.margin_px * scale->disparity);
    std::vector<char> is_new(seen.size());
    parallel_for(seen.size(), [&](std::size_t p) { is_new[p] = !kept.has_near(seen[p]); });
    std::vector<OrientedPoint> added;
    for (std::size_t p = 0; p < seen.size(); ++p)
        if (is_new[p] != 0)
            add_patch(seen[p], scale->pixel, static_cast<int>(std::ceil(scale->pixel / hull.cell)), added);
    points.insert(points.end(), added.begin(), added.end());
    return points;
}

}  // namespace anyrate
