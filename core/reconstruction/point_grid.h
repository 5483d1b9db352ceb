#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/reconstruction/visual_hull.h"

namespace anyrate {

/// Finds oriented points near a place: they are sorted by the cube of space they lie in. Only looks at the points
/// given.
class PointGrid {
public:
    /// @param edge  of a cube, world units: the distance that for_each_near() reaches
    PointGrid(std::span<const OrientedPoint> points, double edge) : points_(points), edge_(edge) {
        places_.reserve(points.size());
        for (std::size_t p = 0; p < points.size(); ++p) places_.push_back({cube_of(points[p].position), p});
        std::sort(places_.begin(), places_.end());
    }

    /// Calls visit(other) for the points no further away than an edge whose normals lie within 90 degrees of this one's
    /// (so that a thin wall's other side does not count), until it returns false. The order is that of the rows of
    /// cubes: where there is a near point at all, the middle row mostly has one.
    template <class Visit>
    void for_each_near(const OrientedPoint& point, const Visit& visit) const {
        static constexpr std::array<std::int32_t, 9> rows = {4, 1, 3, 5, 7, 0, 2, 6, 8};
        const Cube middle = cube_of(point.position);
        for (const std::int32_t row : rows) {
            const Cube first = {middle[0] + row / 3 - 1, middle[1] + row % 3 - 1, middle[2] - 1};
            const Cube last = {first[0], first[1], middle[2] + 1};
            for (auto place = std::lower_bound(places_.begin(), places_.end(), Place{first, 0});
                 place != places_.end() && place->first <= last; ++place) {
                const OrientedPoint& other = points_[place->second];
                if ((other.position - point.position).squaredNorm() < edge_ * edge_ &&
                    other.normal.dot(point.normal) > 0 && !visit(other))
                    return;
            }
        }
    }

private:
    using Cube = std::array<std::int32_t, 3>;  // (z, y, x), so that the cubes of a row follow each other
    using Place = std::pair<Cube, std::size_t>;

    Cube cube_of(const Vec3& point) const {
        const Vec3 p = ((point - points_.front().position) / edge_).array().floor();
        return {static_cast<std::int32_t>(p.z()), static_cast<std::int32_t>(p.y()), static_cast<std::int32_t>(p.x())};
    }

    std::span<const OrientedPoint> points_;
    double edge_;
    std::vector<Place> places_;
};

}  // namespace anyrate
