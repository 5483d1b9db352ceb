#include "core/reconstruction/plane_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include <Eigen/Geometry>

#include "core/parallel.h"
#include "core/reconstruction/float8.h"
#include "core/reconstruction/semi_global.h"
#include "core/reconstruction/window_correlation.h"
#include "core/vector_clones.h"

namespace anyrate {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

using Byte8 = std::uint8_t __attribute__((vector_size(8)));

constexpr int most_neighbours = 16;  // see SweepOptions

// One view at the level swept, cut to what it shows of the object.
struct SweptView {
    PixelBox box;  // in the pixels of the level
    Mat34 P;       // to the pixels of the box
    Vec3 centre;   // of projection, world units
    BrightnessImage grey;
    PatchImage patches;  // of the same
};

PixelBox box_of_object(const PhotoLevel& level) {
    PixelBox box;
    for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x)
            if (level.pixel(x, y)[3] != 0) box.extend(x, y);
    return box;
}

// Unknown where a pixel is not the object's alone, so that what is interpolated from it is, too.
BrightnessImage brightness(const PhotoLevel& level, const PixelBox& box) {
    BrightnessImage grey(box.width(), box.height(), unknown_brightness);
    for (int y = box.y0; y < box.y1; ++y)
        for (int x = box.x0; x < box.x1; ++x) {
            const std::uint8_t* p = level.pixel(x, y);
            if (p[3] != 0) grey(x - box.x0, y - box.y0) = static_cast<std::uint16_t>(p[0] + 2 * p[1] + p[2]);
        }
    return grey;
}

SweptView swept_view(const PhotoView& photo, const PhotoLevel& level) {
    SweptView view;
    view.box = box_of_object(level);
    view.P = with_moved_pixels(level.P, -Vec2(view.box.x0, view.box.y0));
    view.centre = photo.centre;
    view.grey = brightness(level, view.box);
    view.patches = PatchImage(view.grey);
    return view;
}

std::vector<SweptView> views_at(const PhotoImages& images, int level) {
    std::vector<SweptView> views(images.views.size());
    parallel_for(
        views.size(), [&](std::size_t i) { views[i] = swept_view(images.views[i], images.views[i].levels[at(level)]); },
        1);
    return views;
}

struct Neighbour {
    const SweptView* view = nullptr;
    double angle_rad = 0;
    Parallax parallax;  // from the reference view to this one
};

// The views nearest in direction, as seen from the object's middle.
std::vector<Neighbour> neighbours_of(const std::vector<SweptView>& views, std::size_t reference, const Vec3& middle,
                                     const SweepOptions& options) {
    constexpr double degree = std::numbers::pi / 180.0;
    const Vec3 direction = (views[reference].centre - middle).normalized();
    std::vector<Neighbour> neighbours;
    for (std::size_t i = 0; i < views.size(); ++i) {
        const Vec3 other = (views[i].centre - middle).normalized();
        const double angle = std::atan2(direction.cross(other).norm(), direction.dot(other));
        const bool shows_object = views[i].grey.width > 1 && views[i].grey.height > 1;
        if (shows_object && angle >= options.min_angle_deg * degree && angle <= options.max_angle_deg * degree)
            neighbours.push_back(
                {&views[i], angle, parallax_between(views[reference].P, views[reference].centre, views[i].P)});
    }
    std::stable_sort(neighbours.begin(), neighbours.end(),
                     [](const Neighbour& a, const Neighbour& b) { return a.angle_rad < b.angle_rad; });
    if (const std::size_t most = at(std::min(options.n_neighbours, most_neighbours)); neighbours.size() > most)
        neighbours.resize(most);
    return neighbours;
}

// The planes that run through the hull at each pixel of a view: its points drawn with a brush of 3 x 3 pixels.
struct PlaneRanges {
    double farthest = 0;  // inverse depth of plane 0
    double step = 0;      // from plane to plane
    int n_planes = 0;
    Image<std::int16_t> first, last;  // first > last where the hull is not seen

    double inverse_depth(double plane) const { return farthest + plane * step; }
};

// Planes one pixel of disparity apart in the widest neighbour, at the hull's middle.
double plane_step(const SweptView& reference, const std::vector<Neighbour>& neighbours, const Vec3& middle) {
    double px_per_inverse_depth = 0;
    for (const Neighbour& neighbour : neighbours) {
        const Vec3 x = neighbour.view->P * middle.homogeneous();
        const double depth = (reference.P * middle.homogeneous()).z();
        const Vec3 b = neighbour.parallax.b;
        const Vec2 motion = (b.head<2>() - b.z() * x.hnormalized()) * depth / x.z();
        px_per_inverse_depth = std::max(px_per_inverse_depth, motion.norm());
    }
    return 1.0 / px_per_inverse_depth;
}

// The best of the 3 x 3 values around every pixel of an image that is one pixel smaller on each side.
template <class Better>
Image<std::int16_t> best_around(const Image<std::int16_t>& values, const Better& better) {
    Image<std::int16_t> rows(values.width - 2, values.height), best(values.width - 2, values.height - 2);
    for (int y = 0; y < rows.height; ++y)
        for (int x = 0; x < rows.width; ++x)
            rows(x, y) = better(better(values(x, y), values(x + 1, y)), values(x + 2, y));
    for (int y = 0; y < best.height; ++y)
        for (int x = 0; x < best.width; ++x) best(x, y) = better(better(rows(x, y), rows(x, y + 1)), rows(x, y + 2));
    return best;
}

PlaneRanges plane_ranges(const SweptView& reference, const VisualHull& hull, double step) {
    constexpr int most_planes = 400;
    std::vector<Vec3> projected;
    projected.reserve(hull.points.size());
    double nearest = 0, farthest = std::numeric_limits<double>::infinity();
    for (const OrientedPoint& point : hull.points) {
        const Vec3 x = reference.P * point.position.homogeneous();
        if (!(x.z() > 0)) continue;
        const double inverse_depth = 1.0 / x.z();
        projected.push_back({x.x() * inverse_depth, x.y() * inverse_depth, inverse_depth});
        nearest = std::max(nearest, inverse_depth);
        farthest = std::min(farthest, inverse_depth);
    }
    const int w = reference.grey.width, h = reference.grey.height;
    // With a frame of one pixel, where points still reach into the image.
    Image<std::int16_t> first(w + 2, h + 2, std::numeric_limits<std::int16_t>::max()), last(w + 2, h + 2, -1);
    PlaneRanges ranges;
    if (!projected.empty()) {
        ranges.step = std::max(step, (nearest - farthest) / most_planes);
        ranges.farthest = farthest - ranges.step;
        ranges.n_planes = static_cast<int>(std::ceil((nearest - farthest) / ranges.step)) + 3;
    }
    for (const Vec3& x : projected) {
        if (!(x.x() >= -1.5 && x.y() >= -1.5 && x.x() < w + 0.5 && x.y() < h + 0.5)) continue;
        const int px = static_cast<int>(x.x() + 1.5), py = static_cast<int>(x.y() + 1.5);
        const auto plane = static_cast<std::int16_t>((x.z() - ranges.farthest) / ranges.step + 0.5);
        first(px, py) = std::min(first(px, py), plane);
        last(px, py) = std::max(last(px, py), static_cast<std::int16_t>(plane + 1));
    }
    const auto lesser = [](std::int16_t a, std::int16_t b) { return std::min(a, b); };
    const auto greater = [](std::int16_t a, std::int16_t b) { return std::max(a, b); };
    ranges.first = best_around(first, lesser);
    ranges.last = best_around(last, greater);
    return ranges;
}

// Of the correlations with each neighbour, the mean of the better half, as what a plane costs.
ANYRATE_VECTOR_CLONES
void cost_of(std::span<const std::vector<float>> correlations, std::vector<std::uint8_t>& costs) {
    const std::size_t n_best = (correlations.size() + 1) / 2;
    const Float8 zero{}, one = zero + 1.0f;
    for (std::size_t i = 0; i < costs.size(); i += n_lanes) {
        Float8 best[most_neighbours]{};  // in descending order
        for (const std::vector<float>& correlation : correlations) {
            Float8 value;
            std::memcpy(&value, correlation.data() + i, sizeof value);
            for (std::size_t j = 0; j < n_best; ++j) {
                const Float8 larger = best[j] < value ? value : best[j];
                value = best[j] < value ? best[j] : value;
                best[j] = larger;
            }
        }
        Float8 sum{};
        for (std::size_t j = 0; j < n_best; ++j) sum += best[j];
        const Float8 mean = sum / static_cast<float>(n_best);
        const Float8 cost = (one - (mean < one ? mean : one)) * CostVolume::worst_cost + 0.5f;
        const auto bytes = __builtin_convertvector(__builtin_convertvector(cost, Int8), Byte8);
        std::memcpy(costs.data() + i, &bytes, sizeof bytes);
    }
}

// What a sweep of half the resolution found for a view.
struct CoarseDepth {
    PixelBox box;  // of the view at that level
    const DepthMap& map;
};

// Leaves the planes around the depths that are known nearby at half the resolution, at pixels where any is.
void narrow(PlaneRanges& ranges, const PixelBox& box, const CoarseDepth& coarse) {
    constexpr int margin = 2;  // a plane of the coarse map
    const Image<float>& known = coarse.map.inverse_depth;
    for (int y = 0; y < ranges.first.height; ++y)
        for (int x = 0; x < ranges.first.width; ++x) {
            const int cx = (x + box.x0) / 2 - coarse.box.x0, cy = (y + box.y0) / 2 - coarse.box.y0;
            float nearest = 0, farthest = std::numeric_limits<float>::infinity();
            for (int v = std::max(cy - 1, 0); v <= std::min(cy + 1, known.height - 1); ++v)
                for (int u = std::max(cx - 1, 0); u <= std::min(cx + 1, known.width - 1); ++u)
                    if (const float inverse_depth = known(u, v); inverse_depth > 0) {
                        nearest = std::max(nearest, inverse_depth);
                        farthest = std::min(farthest, inverse_depth);
                    }
            if (nearest == 0) continue;
            const auto plane = [&](float inverse_depth) {
                return static_cast<int>(std::lround((inverse_depth - ranges.farthest) / ranges.step));
            };
            const int first = std::max<int>(ranges.first(x, y), plane(farthest) - margin),
                      last = std::min<int>(ranges.last(x, y), plane(nearest) + margin);
            if (first > last) continue;  // beyond the hull
            ranges.first(x, y) = static_cast<std::int16_t>(first);
            ranges.last(x, y) = static_cast<std::int16_t>(last);
        }
}

// Around the pixels that each plane may meet within a tile of the image.
void boxes_of_planes(const CostVolume& volume, const PixelBox& tile, std::vector<PixelBox>& boxes) {
    boxes.assign(at(volume.n_planes), {});
    for (int y = tile.y0; y < tile.y1; ++y)
        for (int x = tile.x0; x < tile.x1; ++x) {
            const auto& [first, n, start] = volume.at(x, y);
            for (int k = first; k < first + n; ++k) boxes[at(k)].extend(x, y);
        }
}

// The costs of all planes that may be the surface.
void sweep(const SweptView& reference, const std::vector<Neighbour>& neighbours, const PlaneRanges& ranges, int radius,
           CostVolume& volume) {
    WindowCorrelation windows(reference.grey, radius);
    std::vector<std::vector<float>> correlations(neighbours.size());
    std::vector<std::uint8_t> costs;
    const auto sweep_box = [&](int k, const PixelBox& box) {
        for (std::size_t i = 0; i < neighbours.size(); ++i)
            windows.correlate(neighbours[i].view->patches, neighbours[i].parallax, ranges.inverse_depth(k), box,
                              correlations[i]);
        costs.resize(correlations.front().size());
        cost_of(correlations, costs);
        const int pitch = WindowCorrelation::pitch_of(box);
        for (int y = box.y0; y < box.y1; ++y)
            for (int x = box.x0; x < box.x1; ++x) {
                const auto& [first, n, start] = volume.at(x, y);
                if (k >= first && k < first + n)
                    volume.costs[start + at(k - first)] = costs[at((y - box.y0) * pitch + x - box.x0)];
            }
    };
    // By tiles, since the pixels of a small part of the image ask for few planes.
    constexpr int tile_side = 32;
    std::vector<PixelBox> boxes;
    for (int y = 0; y < volume.height; y += tile_side)
        for (int x = 0; x < volume.width; x += tile_side) {
            boxes_of_planes(
                volume, {x, y, std::min(x + tile_side, volume.width), std::min(y + tile_side, volume.height)}, boxes);
            for (int k = 0; k < volume.n_planes; ++k)
                if (const PixelBox& box = boxes[at(k)]; !box.is_empty()) sweep_box(k, box);
        }
}

// Where the parabola through three values at -1, 0 and 1, the middle one the least, is least.
double parabola_minimum(double before, double least, double after) {
    const double curvature = before - 2.0 * least + after;
    return curvature > 0.0 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0.0;
}

void choose_planes(const CostVolume& volume, const std::vector<std::int16_t>& sums, const PlaneRanges& ranges,
                   DepthMap& map) {
    for (int y = 0; y < volume.height; ++y)
        for (int x = 0; x < volume.width; ++x) {
            const auto& [first_plane, n, start] = volume.at(x, y);
            if (n == 0) continue;
            const std::int16_t *const first = sums.data() + start, *const last = first + n - 1;
            const std::int16_t* const least = std::min_element(first, last + 1);
            const double shift = least > first && least < last ? parabola_minimum(least[-1], least[0], least[1]) : 0.0;
            const std::ptrdiff_t k = least - first;
            map.inverse_depth(x, y) =
                static_cast<float>(ranges.inverse_depth(static_cast<double>(first_plane + k) + shift));
            map.agreement(x, y) =
                1.0f - static_cast<float>(volume.costs[start + static_cast<std::size_t>(k)]) / CostVolume::worst_cost;
        }
}

DepthMap depth_map(const std::vector<SweptView>& views, std::size_t i, const VisualHull& hull,
                   const std::optional<CoarseDepth>& coarse, const SweepOptions& options) {
    const SweptView& reference = views[i];
    const int w = reference.grey.width, h = reference.grey.height;
    DepthMap map;
    map.P = reference.P;
    map.inverse_depth = Image<float>(w, h, 0.0f);
    map.agreement = Image<float>(w, h, 0.0f);
    const Vec3 middle = 0.5 * (hull.lower + hull.upper);
    const auto neighbours = neighbours_of(views, i, middle, options);
    if (neighbours.empty() || w < 2 || h < 2) return map;
    const double step = plane_step(reference, neighbours, middle);
    if (!(step > 0)) return map;  // the hull's middle lies beside a camera

    PlaneRanges ranges = plane_ranges(reference, hull, step);
    if (coarse) narrow(ranges, reference.box, *coarse);
    map.step = ranges.step;
    for (std::size_t p = 0; p < ranges.last.pixels.size(); ++p)
        if (reference.grey.pixels[p] == unknown_brightness) ranges.last.pixels[p] = -1;
    CostVolume volume(ranges.n_planes, ranges.first, ranges.last);
    sweep(reference, neighbours, ranges, options.window_radius_px, volume);
    choose_planes(volume, semi_global_sums(volume), ranges, map);
    return map;
}

}  // namespace

int swept_level(const PhotoImages& images, const SweepOptions& options) {
    for (int l = 0; l < images.n_levels(); ++l) {
        std::size_t n_object = 0;
        for (const PhotoView& view : images.views) {
            const auto& rgba = view.levels[at(l)].rgba;
            for (std::size_t i = 3; i < rgba.size(); i += 4) n_object += rgba[i] != 0;
        }
        if (n_object <= at(options.most_object_px) * images.views.size()) return l;
    }
    return images.n_levels() - 1;
}

std::vector<DepthMap> plane_sweep(const PhotoImages& images, const VisualHull& hull, const SweepOptions& options) {
    const int level = swept_level(images, options);
    std::vector<SweptView> views;
    std::vector<DepthMap> maps;
    for (int l = std::min(level + 1, images.n_levels() - 1); l >= level; --l) {
        const std::vector<SweptView> coarse_views = std::exchange(views, views_at(images, l));
        const std::vector<DepthMap> coarse_maps = std::exchange(maps, std::vector<DepthMap>(views.size()));
        parallel_for(
            maps.size(),
            [&](std::size_t i) {
                std::optional<CoarseDepth> coarse;
                if (!coarse_maps.empty()) coarse.emplace(CoarseDepth{coarse_views[i].box, coarse_maps[i]});
                maps[i] = depth_map(views, i, hull, coarse, options);
            },
            1);
    }
    return maps;
}

}  // namespace anyrate
