#include "core/reconstruction/confirmed_depth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/parallel.h"

namespace anyrate {
namespace {

// A map and the way back from its pixels to the world.
struct DepthView {
    const DepthMap* map;
    Mat3 world_from_pixel;
    Vec3 centre;

    explicit DepthView(const DepthMap& depths)
        : map(&depths),
          world_from_pixel(depths.P.leftCols<3>().inverse()),
          centre(-world_from_pixel * depths.P.col(3)) {}

    Vec3 to_world(double x, double y, double inverse_depth) const {
        return centre + world_from_pixel * Vec3(x, y, 1.0) / inverse_depth;
    }
};

bool look_from_near(const DepthView& a, const DepthView& b, const Vec3& point, double least_cos) {
    const Vec3 to_a = a.centre - point, to_b = b.centre - point;
    const double dot = to_a.dot(to_b);
    return dot > 0 && dot * dot >= least_cos * least_cos * to_a.squaredNorm() * to_b.squaredNorm();
}

// Around every point that any map knows.
struct Sphere {
    Vec3 centre = Vec3::Zero();
    double radius = 0;
};

Sphere object_of(std::span<const DepthView> views) {
    std::vector<Eigen::AlignedBox3d> boxes(views.size());
    parallel_for(
        views.size(),
        [&](std::size_t i) {
            const Image<float>& depths = views[i].map->inverse_depth;
            for (int y = 0; y < depths.height; ++y)
                for (int x = 0; x < depths.width; ++x)
                    if (depths(x, y) > 0) boxes[i].extend(views[i].to_world(x, y, depths(x, y)));
        },
        1);
    Eigen::AlignedBox3d all;
    for (const Eigen::AlignedBox3d& box : boxes) all.extend(box);
    if (all.isEmpty()) return {};
    return {all.center(), 0.5 * all.diagonal().norm()};
}

enum class Finding { nothing, confirms, contradicts };

// The views of which some point of the object may look_from_near() with `own`. Seen from a point, two cameras differ in
// direction by no more than seen from the object's middle and the angles by which the point is off the middle in both.
std::vector<const DepthView*> views_near(std::span<const DepthView> views, const DepthView& own, const Sphere& object,
                                         double max_angle_rad) {
    const auto off_middle = [&](const DepthView& view) {
        const double distance = (view.centre - object.centre).norm();
        return distance > object.radius ? std::asin(object.radius / distance) : std::numbers::pi;
    };
    std::vector<const DepthView*> near;
    for (const DepthView& other : views) {
        const Vec3 a = own.centre - object.centre, b = other.centre - object.centre;
        const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
        if (&other != &own && angle <= max_angle_rad + off_middle(own) + off_middle(other)) near.push_back(&other);
    }
    return near;
}

// What a map says of a point, from the four pixels around it: on a slanted surface their depths differ by more than the
// tolerance, so one is enough to confirm; to see through the point takes all that are known, at least three. A map that
// has something in front of the point says nothing: the point may be hidden there.
Finding find(const DepthMap& map, const Vec3& point, const ConfirmOptions& options) {
    const Vec3 x = map.P * point.homogeneous();
    if (!(x.z() > 0)) return Finding::nothing;
    const double u = x.x() / x.z(), v = x.y() / x.z();
    const auto& known = map.inverse_depth;
    if (!(u >= 0 && v >= 0 && u < known.width - 1 && v < known.height - 1)) return Finding::nothing;
    const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
    int n_through = 0;
    for (int i = 0; i < 4; ++i) {
        const double inverse_depth = known(x0 + (i & 1), y0 + (i >> 1));
        if (!(inverse_depth > 0)) continue;
        const double in_front_px = (1.0 / x.z() - inverse_depth) / map.step;
        if (std::abs(in_front_px) <= options.tolerance_px) return Finding::confirms;
        n_through += in_front_px > options.conflict_px;
    }
    return n_through >= 3 ? Finding::contradicts : Finding::nothing;
}

// At every pixel of a map: how many other views have a point there that the map sees through.
Image<std::uint16_t> count_seen_through(std::span<const DepthView* const> others, const DepthView& own,
                                        double least_cos, const ConfirmOptions& options) {
    const Image<float>& known = own.map->inverse_depth;
    Image<std::uint16_t> count(known.width, known.height, 0);
    Image<const DepthView*> last(known.width, known.height, nullptr);  // that was counted at a pixel
    for (const DepthView* const other : others) {
        const Image<float>& depths = other->map->inverse_depth;
        for (int y = 0; y < depths.height; ++y)
            for (int x = 0; x < depths.width; ++x) {
                if (!(depths(x, y) > 0)) continue;
                const Vec3 point = other->to_world(x, y, depths(x, y));
                const Vec3 p = own.map->P * point.homogeneous();
                const double u = p.x() / p.z() + 0.5, v = p.y() / p.z() + 0.5;
                if (!(p.z() > 0 && u >= 0 && v >= 0 && u < known.width && v < known.height)) continue;
                const int px = static_cast<int>(u), py = static_cast<int>(v);
                const double inverse_depth = known(px, py);
                if (!(inverse_depth > 0) || last(px, py) == other) continue;
                if ((1.0 / p.z() - inverse_depth) / own.map->step <= options.conflict_px) continue;
                if (!look_from_near(own, *other, point, least_cos)) continue;
                last(px, py) = other;
                ++count(px, py);
            }
    }
    return count;
}

// Both kinds of what is left of one map.
struct ConfirmedDepth {
    DepthMap found, confirmed;
};

ConfirmedDepth confirm(std::span<const DepthView> views, const DepthView& own, const Sphere& object,
                       const ConfirmOptions& options) {
    const double max_angle_rad = options.max_angle_deg * std::numbers::pi / 180.0, least_cos = std::cos(max_angle_rad);
    const std::vector<const DepthView*> others = views_near(views, own, object, max_angle_rad);
    const auto n_seen_through = count_seen_through(others, own, least_cos, options);
    enum class Standing { unknown, found, confirmed };
    const auto standing_of = [&](int x, int y) {
        if (!(own.map->agreement(x, y) >= options.least_agreement)) return Standing::unknown;
        const Vec3 point = own.to_world(x, y, own.map->inverse_depth(x, y));
        int n_confirm = 0, n_contradict = n_seen_through(x, y);
        for (const DepthView* const other : others) {
            if (!look_from_near(own, *other, point, least_cos)) continue;
            const Finding finding = find(*other->map, point, options);
            n_confirm += finding == Finding::confirms;
            n_contradict += finding == Finding::contradicts;
        }
        if (n_confirm < options.n_views) return Standing::unknown;
        return n_confirm > 2 * n_contradict ? Standing::confirmed : Standing::found;
    };
    const Image<float>& known = own.map->inverse_depth;
    const DepthMap nothing{own.map->P, own.map->step, Image<float>(known.width, known.height, 0.0f), {}};
    ConfirmedDepth result{nothing, nothing};
    for (int y = 0; y < known.height; ++y)
        for (int x = 0; x < known.width; ++x) {
            if (!(known(x, y) > 0)) continue;
            const Standing standing = standing_of(x, y);
            if (standing != Standing::unknown) result.found.inverse_depth(x, y) = known(x, y);
            if (standing == Standing::confirmed) result.confirmed.inverse_depth(x, y) = known(x, y);
        }
    return result;
}

}  // namespace

ConfirmedDepths confirm_depths(std::span<const DepthMap> maps, const ConfirmOptions& options) {
    std::vector<DepthView> views;
    std::vector<std::size_t> swept;
    for (std::size_t i = 0; i < maps.size(); ++i)
        if (maps[i].step > 0) {
            views.emplace_back(maps[i]);
            swept.push_back(i);
        }
    const Sphere object = object_of(views);
    ConfirmedDepths result{std::vector<DepthMap>(maps.size()), std::vector<DepthMap>(maps.size())};
    parallel_for(
        views.size(),
        [&](std::size_t i) {
            auto [found, confirmed] = confirm(views, views[i], object, options);
            result.found[swept[i]] = std::move(found);
            result.confirmed[swept[i]] = std::move(confirmed);
        },
        1);
    return result;
}

}  // namespace anyrate
