#include "core/reconstruction/silhouette_term.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "core/parallel.h"
#include "core/reconstruction/float8.h"
#include "core/reconstruction/inverse_depth.h"
#include "core/vector_clones.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

constexpr double eighths = 8.0;
constexpr int max_coverage_side = 1024;  ///< of the coverage images

/// Lower envelope of the parabolas (x - i)^2 + f[i]: the exact one-dimensional squared distance transform.
/// Source: Felzenszwalb and Huttenlocher 2012, "Distance Transforms of Sampled Functions".
void distance_transform_1d(std::span<const float> f, std::span<float> out, std::vector<int>& apex,
                           std::vector<float>& from) {
    const int n = static_cast<int>(f.size());
    apex.assign(f.size(), 0);
    from.assign(f.size() + 1, 0.0F);
    int k = 0;
    from[0] = -std::numeric_limits<float>::infinity();
    from[1] = std::numeric_limits<float>::infinity();
    const auto meet = [&](int q, int p) {
        const auto dq = static_cast<float>(q), dp = static_cast<float>(p);
        return ((f[at(q)] + dq * dq) - (f[at(p)] + dp * dp)) / (2 * dq - 2 * dp);
    };
    for (int q = 1; q < n; ++q) {
        float s = meet(q, apex[at(k)]);
        while (s <= from[at(k)]) s = meet(q, apex[at(--k)]);
        ++k;
        apex[at(k)] = q;
        from[at(k)] = s;
        from[at(k) + 1] = std::numeric_limits<float>::infinity();
    }
    k = 0;
    for (int q = 0; q < n; ++q) {
        while (from[at(k) + 1] < static_cast<float>(q)) ++k;
        const auto d = static_cast<float>(q - apex[at(k)]);
        out[at(q)] = d * d + f[at(apex[at(k)])];
    }
}

/// Squared distance in pixels from every pixel to the nearest one for which `is_target` holds.
template <class Predicate>
std::vector<float> squared_distance(int width, int height, const Predicate& is_target) {
    constexpr float far = 1e12F;
    std::vector<float> d(at(width) * at(height)), line, out;
    std::vector<int> apex;
    std::vector<float> from;
    line.resize(at(height));
    out.resize(at(height));
    for (int x = 0; x < width; ++x) {
        for (int y = 0; y < height; ++y) line[at(y)] = is_target(x, y) ? 0.0F : far;
        distance_transform_1d(line, out, apex, from);
        for (int y = 0; y < height; ++y) d[at(y) * at(width) + at(x)] = out[at(y)];
    }
    line.resize(at(width));
    out.resize(at(width));
    for (int y = 0; y < height; ++y) {
        float* row = d.data() + at(y) * at(width);
        std::copy(row, row + width, line.begin());
        distance_transform_1d(line, out, apex, from);
        std::copy(out.begin(), out.end(), row);
    }
    return d;
}

bool is_front(const SurfaceView& surface, std::int32_t face, const Vec3& centre) {
    const Triangle& t = surface.triangles[at(face)];
    const Vec3& a = surface.vertices[at(t[0])];
    return (surface.vertices[at(t[1])] - a).cross(surface.vertices[at(t[2])] - a).dot(centre - a) > 0;
}

bool is_on_rim(const SurfaceView& surface, std::span<const std::int32_t> ring, const Vec3& centre) {
    bool front = false, back = false;
    for (std::int32_t f : ring) (is_front(surface, f, centre) ? front : back) = true;
    return front && back;
}

/// Eight points, a lane each, counted from the first of them: so near it, single precision tells pixels apart.
struct PointLanes {
    Vec3 first;
    Float8 x{}, y{}, z{};

    /// @param vertices  one to eight; the lanes left over are the first one again
    PointLanes(std::span<const Vec3> points, std::span<const std::int32_t> vertices) : first(points[at(vertices[0])]) {
        for (std::size_t lane = 0; lane < vertices.size(); ++lane) {
            const Vec3 offset = points[at(vertices[lane])] - first;
            x[lane] = static_cast<float>(offset.x());
            y[lane] = static_cast<float>(offset.y());
            z[lane] = static_cast<float>(offset.z());
        }
    }
};

/// Most points are deep inside a mask, where it says nothing of them: which ones may not be.
/// @param reach_px  of the border; points up to two pixels further inside may be found, too
/// @return whether any may be near
ANYRATE_VECTOR_CLONES
bool find_near_border(const Silhouettes::View& view, const PointLanes& points, double reach_px, Int8& is_near) {
    const Image<std::int8_t>& image = *view.distance;
    const Vec3 first = view.P * points.first.homogeneous();
    Float8 projected[3];
    for (int i = 0; i < 3; ++i)
        projected[i] = static_cast<float>(first[i]) +
                       (static_cast<float>(view.P(i, 0)) * points.x + static_cast<float>(view.P(i, 1)) * points.y +
                        static_cast<float>(view.P(i, 2)) * points.z);
    const Float8 zero{}, u = projected[0] / projected[2], v = projected[1] / projected[2];
    const auto right = static_cast<float>(image.width - 1), bottom = static_cast<float>(image.height - 1);
    constexpr float margin = 0.1F;  // pixels: term_in() knows it exactly
    const Int8 in_image =
        (projected[2] > 0) & (u >= -margin) & (v >= -margin) & (u < right + margin) & (v < bottom + margin);
    const Float8 x = u < zero ? zero : u, y = v < zero ? zero : v;
    const Int8 column = __builtin_convertvector(in_image ? x : zero, Int8);
    const Int8 row = __builtin_convertvector(in_image ? y : zero, Int8);
    const Int8 pixel = row * image.width + column;
    Int8 distance;
    for (std::size_t lane = 0; lane < n_lanes; ++lane) distance[lane] = image.pixels[at(pixel[lane])];
    // From one of the four pixels around a point to the next the distance changes by no more than the way between them.
    is_near = in_image & (distance <= static_cast<std::int32_t>(eighths * (reach_px + 2)));
    std::int32_t found = 0;
    for (std::size_t lane = 0; lane < n_lanes; ++lane) found |= is_near[lane];
    return found != 0;
}

}  // namespace

Image<std::int8_t> silhouette_distance(const MaskImage& mask) {
    const auto to_inside = squared_distance(mask.width, mask.height, [&](int x, int y) { return mask(x, y) != 0; });
    const auto to_outside = squared_distance(mask.width, mask.height, [&](int x, int y) { return mask(x, y) == 0; });
    Image<std::int8_t> distance(mask.width, mask.height);
    for (std::size_t i = 0; i < distance.pixels.size(); ++i) {
        // From a pixel's centre to the border is half a pixel less than to the nearest centre beyond it.
        const double d = to_outside[i] > 0 ? std::sqrt(to_outside[i]) - 0.5 : 0.5 - std::sqrt(to_inside[i]);
        distance.pixels[i] = static_cast<std::int8_t>(std::clamp(std::lround(eighths * d), -127L, 127L));
    }
    return distance;
}

Silhouettes::Silhouettes(const Capture& capture) : views_(capture.views.size()), given_(capture.views.size()) {
    parallel_for(
        views_.size(),
        [&](std::size_t i) {
            const auto& view = capture.views[i];
            views_[i].P = view.camera.P();
            views_[i].centre = view.camera.centre();
            given_[i] = views_[i].distance = std::make_shared<Image<std::int8_t>>(silhouette_distance(view.mask));
            PhotoLevel& level = views_[i].coverage_level;
            level.width = view.mask.width;
            level.height = view.mask.height;
            level.P = views_[i].P;
            do {  // a rim vertex looks two pixels ahead: half the resolution tells as well, for a quarter of the time
                level = without_colours(level);
                views_[i].coverage_scale /= 2;
            } while (std::max(level.width, level.height) > max_coverage_side);
        },
        1);
}

void Silhouettes::shift_views(std::span<const Vec2> shifts) {
    for (std::size_t i = 0; i < shifts.size(); ++i) {
        View& view = views_[i];
        view.P = with_moved_pixels(view.P, shifts[i]);
        view.coverage_level.P = with_moved_pixels(view.coverage_level.P, view.coverage_scale * shifts[i]);
    }
}

void Silhouettes::look(const SurfaceView& surface) {
    parallel_for(
        views_.size(),
        [&](std::size_t i) { views_[i].coverage = render_inverse_depth(views_[i].coverage_level, surface); }, 1);
}

void Silhouettes::grow_masks(double px) {
    assert(std::abs(px) <= most_growth_px);
    growth_px_ = px;
    const int by = static_cast<int>(std::lround(eighths * px));
    for (std::size_t i = 0; i < views_.size(); ++i) {
        auto grown = std::make_shared<Image<std::int8_t>>(*given_[i]);
        for (std::int8_t& d : grown->pixels) d = static_cast<std::int8_t>(std::clamp(d + by, -127, 127));
        views_[i].distance = std::move(grown);
    }
}

/// A vertex near the border of a view's mask.
struct Silhouettes::Sight {
    Vec2 pixel;
    Vec2 motion;          ///< of the pixel by the displacement along the normal
    double distance = 0;  ///< to the border, pixels, positive inside
    double slope = 0;     ///< its change by the displacement
};

std::optional<Silhouettes::Sight> Silhouettes::sight_of(const View& view, const Vec3& point, const Vec3& normal,
                                                        double reach_px) {
    const Vec3 x = view.P * point.homogeneous();
    if (x.z() <= 0) return {};
    const double u = x.x() / x.z(), v = x.y() / x.z();
    const Image<std::int8_t>& image = *view.distance;
    if (!(u >= 0 && v >= 0 && u < image.width - 1 && v < image.height - 1)) return {};
    const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
    const double fu = u - x0, fv = v - y0;
    const double a = image(x0, y0), b = image(x0 + 1, y0), c = image(x0, y0 + 1), d = image(x0 + 1, y0 + 1);
    const double distance = ((1 - fv) * (a + fu * (b - a)) + fv * (c + fu * (d - c))) / eighths;
    const double dx = ((1 - fv) * (b - a) + fv * (d - c)) / eighths, dy = ((1 - fu) * (c - a) + fu * (d - b)) / eighths;
    if (distance > reach_px) return {};  // see find_near_border()
    const Vec3 q = view.P.leftCols<3>() * normal;
    const Vec2 motion = Vec2(q.x() - u * q.z(), q.y() - v * q.z()) / x.z();
    return Sight{.pixel = {u, v}, .motion = motion, .distance = distance, .slope = dx * motion.x() + dy * motion.y()};
}

/// Whether nothing of the surface is just beyond a rim vertex. Else the contour lies within the object's outline.
bool Silhouettes::ends_beyond(const View& view, const Sight& sight) {
    if (sight.motion.isZero(0)) return false;
    const Vec2 beyond = sight.pixel + beyond_px * sight.motion.normalized();
    const auto at_level = [&](double x) {
        return static_cast<int>(std::lround((x + 0.5) * view.coverage_scale - 0.5));
    };
    const int x = at_level(beyond.x()), y = at_level(beyond.y());
    return !(view.coverage.contains(x, y) && view.coverage(x, y) > 0);
}

template <class IsOnRim>
SilhouetteTerm Silhouettes::term_in(const View& view, const Vec3& point, const Vec3& normal, double reach_px,
                                    const IsOnRim& is_on_rim) {
    const std::optional<Sight> sight = sight_of(view, point, normal, reach_px);
    if (!sight || (sight->distance >= 0 && !(is_on_rim() && ends_beyond(view, *sight)))) return {};
    const auto [distance, slope] = std::pair(sight->distance, sight->slope);
    return {.energy = distance * distance, .gradient = 2 * distance * slope, .hessian = 2 * slope * slope};
}

std::vector<double> Silhouettes::contour_distances(const SurfaceView& surface, const OneRings& rings,
                                                   std::span<const Vec3> normals, double reach_px) const {
    std::vector<std::vector<double>> by_view(views_.size());
    parallel_for(
        views_.size(),
        [&](std::size_t i) {
            const View& view = views_[i];
            for (std::int32_t v = 0; v < surface.n_vertices(); ++v) {
                const auto sight = sight_of(view, surface.vertices[at(v)], normals[at(v)], reach_px);
                if (sight && is_on_rim(surface, rings.faces(v), view.centre) && ends_beyond(view, *sight))
                    by_view[i].push_back(sight->distance);
            }
        },
        1);
    std::vector<double> all;
    for (const auto& distances : by_view) all.insert(all.end(), distances.begin(), distances.end());
    return all;
}

std::vector<SilhouetteTerm> Silhouettes::terms(const SurfaceView& surface, const OneRings& rings,
                                               std::span<const Vec3> normals, std::span<const std::int32_t> vertices,
                                               double reach_px) const {
    std::vector<SilhouetteTerm> result(vertices.size());
    parallel_for((vertices.size() + n_lanes - 1) / n_lanes,
                 [&](std::size_t group) {
                     const std::size_t begin = group * n_lanes, n = std::min(n_lanes, vertices.size() - begin);
                     const PointLanes points(surface.vertices, vertices.subspan(begin, n));
                     for (const View& view : views_) {
                         Int8 is_near;
                         if (!find_near_border(view, points, reach_px, is_near)) continue;
                         for (std::size_t lane = 0; lane < n; ++lane) {
                             if (is_near[lane] == 0) continue;
                             const std::int32_t v = vertices[begin + lane];
                             const SilhouetteTerm term =
                                 term_in(view, surface.vertices[at(v)], normals[at(v)], reach_px,
                                         [&] { return is_on_rim(surface, rings.faces(v), view.centre); });
                             SilhouetteTerm& sum = result[begin + lane];
                             sum.energy += term.energy;
                             sum.gradient += term.gradient;
                             sum.hessian += term.hessian;
                         }
                     }
                 },
                 8);
    return result;
}

}  // namespace anyrate
