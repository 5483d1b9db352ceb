#include "core/reconstruction/seen_through.h"

#include <cmath>

#include "core/parallel.h"

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
        const double in_front_px = (1.0 / x.z() - inverse_depth) / map.step;
        n_surface += std::abs(in_front_px) <= margin_px;
        n_through += in_front_px > margin_px;
    }
    return n_surface > 0 ? Sight::surface : n_through == 4 ? Sight::through : Sight::nothing;
}

// A thin part may vanish before its background in some views, never in most: those that find it outvote twice as many.
bool is_seen_through(const Vec3& point, std::span<const DepthMap> maps, const SeenThroughOptions& options) {
    int n_surface = 0, n_through = 0;
    for (const DepthMap& map : maps) {
        const Sight sight = look_at(map, point, options.margin_px);
        n_surface += sight == Sight::surface;
        n_through += sight == Sight::through;
    }
    return n_through >= options.n_views && n_through > 2 * n_surface;
}

}  // namespace

std::vector<OrientedPoint> without_seen_through(std::span<const OrientedPoint> points, std::span<const DepthMap> maps,
                                                const SeenThroughOptions& options) {
    std::vector<char> floats(points.size());
    parallel_for(points.size(), [&](std::size_t p) { floats[p] = is_seen_through(points[p].position, maps, options); });
    std::vector<OrientedPoint> kept;
    for (std::size_t p = 0; p < points.size(); ++p)
        if (floats[p] == 0) kept.push_back(points[p]);
    return kept;
}

}  // namespace anyrate
