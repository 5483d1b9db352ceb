#include "core/reconstruction/confirmed_depth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/parallel.h"
#include "core/reconstruction/float8.h"
#include "core/reconstruction/parallax.h"
#include "core/vector_clones.h"

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

// Eight neighbouring pixels of a row of a map, and the points it has there.
struct PointLanes {
    Float8 x, y, inverse_depth;  ///< inverse depth is 0 where nothing is known
    Float8 to_own[3];            ///< from the points to the map's centre, world units
};

// Where the points of one map stand in another: all in numbers that are small beside a pixel's, so that single
// precision does.
class Passage {
public:
    Passage(const DepthView& from, const DepthView& to)
        : between_((to.centre - from.centre).cast<float>()), map_(to.map) {
        const Parallax parallax = parallax_between(from.map->P, from.centre, to.map->P);
        A_ = parallax.A.cast<float>();
        b_ = parallax.b.cast<float>();
    }

    const DepthMap& map() const { return *map_; }

    // Pixels and inverse depths in the other map. `inside`: in front of it.
    [[gnu::always_inline]] void carry(const PointLanes& points, Float8& u, Float8& v, Float8& inverse_depth,
                                      Int8& inside) const {
        const Float8 zero{}, one = zero + 1.0f;
        Float8 p[3];
        for (int i = 0; i < 3; ++i)
            p[i] = A_(i, 0) * points.x + A_(i, 1) * points.y + A_(i, 2) + b_[i] * points.inverse_depth;
        inside = (p[2] > 0) & (points.inverse_depth > 0);
        const Float8 inverse_z = one / (inside ? p[2] : one);
        u = p[0] * inverse_z;
        v = p[1] * inverse_z;
        inverse_depth = points.inverse_depth * inverse_z;
    }

    // Which points look at both centres in directions no further apart than an angle, given by its cosine, which is not
    // negative.
    [[gnu::always_inline]] void look_from_near(const PointLanes& points, float least_cos, Int8& near) const {
        Float8 dot{}, a{}, b{};
        for (int i = 0; i < 3; ++i) {
            const Float8 to_other = points.to_own[i] + between_[i];
            dot += points.to_own[i] * to_other;
            a += points.to_own[i] * points.to_own[i];
            b += to_other * to_other;
        }
        near = (dot > 0) & (dot * dot >= least_cos * least_cos * a * b);
    }

private:
    Eigen::Matrix3f A_;
    Eigen::Vector3f b_, between_;
    const DepthMap* map_;
};

// From pixel x on; what is beyond the row is unknown.
[[gnu::always_inline]] inline void load(const DepthView& view, int x, int y, PointLanes& points) {
    const Image<float>& depths = view.map->inverse_depth;
    const Float8 zero{}, one = zero + 1.0f;
    points.inverse_depth = zero;
    std::memcpy(&points.inverse_depth, &depths(x, y),
                sizeof(float) * std::min(n_lanes, static_cast<std::size_t>(depths.width - x)));
    points.x = Float8{0, 1, 2, 3, 4, 5, 6, 7} + static_cast<float>(x);
    points.y = zero + static_cast<float>(y);
    const Float8 depth = one / (points.inverse_depth > 0 ? points.inverse_depth : one);
    for (int i = 0; i < 3; ++i) {
        const auto m = [&](int j) { return static_cast<float>(view.world_from_pixel(i, j)); };
        points.to_own[i] = -(m(0) * points.x + m(1) * points.y + m(2)) * depth;
    }
}

bool any(const Int8& lanes) {
    std::int32_t bits = 0;
    for (std::size_t lane = 0; lane < n_lanes; ++lane) bits |= lanes[lane];
    return bits != 0;
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

// What a map says of points, from the four pixels around each: on a slanted surface their depths differ by more than
// the tolerance, so one is enough to confirm; to see through the point takes all that are known, at least three. A map
// that has something in front of the point says nothing: the point may be hidden there.
// @param n_confirm, n_contradict  are counted up
ANYRATE_VECTOR_CLONES
void ask(const Passage& passage, const PointLanes& points, float least_cos, const ConfirmOptions& options,
         Int8& n_confirm, Int8& n_contradict) {
    const DepthMap& map = passage.map();
    const Image<float>& known = map.inverse_depth;
    Float8 u, v, here;
    Int8 inside, near;
    passage.carry(points, u, v, here, inside);
    inside &=
        (u >= 0) & (v >= 0) & (u < static_cast<float>(known.width - 1)) & (v < static_cast<float>(known.height - 1));
    if (!any(inside)) return;
    const Float8 zero{};
    const Int8 pixel = __builtin_convertvector(inside ? v : zero, Int8) * known.width +
                       __builtin_convertvector(inside ? u : zero, Int8);
    const auto tolerance = static_cast<float>(options.tolerance_px * map.step),
               conflict = static_cast<float>(options.conflict_px * map.step);
    Int8 confirms{}, n_through{};
    for (const int offset : {0, 1, known.width, known.width + 1}) {
        Float8 inverse_depth;
        for (std::size_t lane = 0; lane < n_lanes; ++lane)
            inverse_depth[lane] = known.pixels[static_cast<std::size_t>(pixel[lane] + offset)];
        const Int8 is_known = inverse_depth > 0;
        const Float8 in_front = here - inverse_depth;
        confirms |= is_known & (in_front <= tolerance) & (in_front >= -tolerance);
        n_through -= is_known & (in_front > conflict);  // true is -1
    }
    passage.look_from_near(points, least_cos, near);
    confirms &= inside & near;
    n_confirm -= confirms;
    n_contradict -= inside & near & ~confirms & (n_through >= 3);
}

// Where the points of a row of a map are seen through by another: the pixel there, or -1.
ANYRATE_VECTOR_CLONES
void find_seen_through(const Passage& passage, const PointLanes& points, float least_cos, double conflict_px,
                       Int8& pixel) {
    const Image<float>& known = passage.map().inverse_depth;
    const auto conflict = static_cast<float>(conflict_px * passage.map().step);
    Float8 u, v, there, inverse_depth;
    Int8 inside, near;
    passage.carry(points, u, v, there, inside);
    u += 0.5f;
    v += 0.5f;
    inside &= (u >= 0) & (v >= 0) & (u < static_cast<float>(known.width)) & (v < static_cast<float>(known.height));
    const Float8 zero{};
    pixel = __builtin_convertvector(inside ? v : zero, Int8) * known.width +
            __builtin_convertvector(inside ? u : zero, Int8);
    for (std::size_t lane = 0; lane < n_lanes; ++lane)
        inverse_depth[lane] = known.pixels[static_cast<std::size_t>(pixel[lane])];
    inside &= (inverse_depth > 0) & (there - inverse_depth > conflict);
    if (any(inside)) {
        passage.look_from_near(points, least_cos, near);
        inside &= near;
    }
    pixel |= ~inside;
}

// At every pixel of a map: how many other views have a point there that the map sees through.
Image<std::uint16_t> count_seen_through(std::span<const DepthView* const> others, const DepthView& own, float least_cos,
                                        const ConfirmOptions& options) {
    const Image<float>& known = own.map->inverse_depth;
    Image<std::uint16_t> count(known.width, known.height, 0);
    Image<const DepthView*> last(known.width, known.height, nullptr);  // that was counted at a pixel
    for (const DepthView* const other : others) {
        const Passage passage(*other, own);
        for (int y = 0; y < other->map->inverse_depth.height; ++y)
            for (int x = 0; x < other->map->inverse_depth.width; x += static_cast<int>(n_lanes)) {
                PointLanes points;
                load(*other, x, y, points);
                if (!any(points.inverse_depth > 0)) continue;
                Int8 pixels;
                find_seen_through(passage, points, least_cos, options.conflict_px, pixels);
                for (std::size_t lane = 0; lane < n_lanes; ++lane) {
                    if (pixels[lane] < 0) continue;
                    const auto p = static_cast<std::size_t>(pixels[lane]);
                    if (std::exchange(last.pixels[p], other) != other) ++count.pixels[p];
                }
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
    const double max_angle_rad = options.max_angle_deg * std::numbers::pi / 180.0;
    const auto least_cos = static_cast<float>(std::cos(max_angle_rad));
    const std::vector<const DepthView*> others = views_near(views, own, object, max_angle_rad);
    const auto n_seen_through = count_seen_through(others, own, least_cos, options);
    std::vector<Passage> passages;
    for (const DepthView* const other : others)
        if (const Image<float>& map = other->map->inverse_depth; map.width > 1 && map.height > 1)
            passages.emplace_back(own, *other);
    const Image<float>& known = own.map->inverse_depth;
    const DepthMap nothing{own.map->P, own.map->step, Image<float>(known.width, known.height, 0.0f), {}};
    ConfirmedDepth result{nothing, nothing};
    result.confirmed.agreement = own.map->agreement;
    for (int y = 0; y < known.height; ++y)
        for (int x = 0; x < known.width; x += static_cast<int>(n_lanes)) {
            PointLanes points;
            load(own, x, y, points);
            const int n = std::min(static_cast<int>(n_lanes), known.width - x);
            for (int lane = 0; lane < n; ++lane)
                if (!(own.map->agreement(x + lane, y) >= options.least_agreement)) points.inverse_depth[lane] = 0;
            if (!any(points.inverse_depth > 0)) continue;
            Int8 n_confirm{}, n_contradict{};
            for (const Passage& passage : passages) ask(passage, points, least_cos, options, n_confirm, n_contradict);
            for (int lane = 0; lane < n; ++lane) {
                if (!(points.inverse_depth[lane] > 0)) continue;
                const int n_against = n_contradict[lane] + n_seen_through(x + lane, y);
                const bool is_confirmed = n_confirm[lane] > 2 * n_against;
                if (is_confirmed || n_confirm[lane] >= options.n_views)
                    result.found.inverse_depth(x + lane, y) = points.inverse_depth[lane];
                if (is_confirmed) result.confirmed.inverse_depth(x + lane, y) = points.inverse_depth[lane];
            }
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
