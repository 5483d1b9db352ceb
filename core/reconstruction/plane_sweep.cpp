#include "core/reconstruction/plane_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/parallel.h"
#include "core/reconstruction/semi_global.h"

namespace anyrate {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

// Brightness in -1 .. 1; unknown where a pixel is not the object's alone, so that what is interpolated from it is too.
Image<float> brightness(const PhotoLevel& level) {
    Image<float> grey(level.width, level.height, unknown);
    for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x) {
            const std::uint8_t* p = level.pixel(x, y);
            if (p[3] != 0) grey(x, y) = static_cast<float>(p[0] + 2 * p[1] + p[2]) / 510.0f - 1.0f;
        }
    return grey;
}

float interpolate(const Image<float>& image, float x, float y) {
    if (!(x >= 0.0f && y >= 0.0f && x < static_cast<float>(image.width - 1) &&
          y < static_cast<float>(image.height - 1)))
        return unknown;
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const float u = x - static_cast<float>(x0), v = y - static_cast<float>(y0);
    const float* top = image.pixels.data() + at(y0) * at(image.width) + at(x0);
    const float* bottom = top + image.width;
    const float upper = top[0] + u * (top[1] - top[0]);
    return upper + v * (bottom[0] + u * (bottom[1] - bottom[0]) - upper);
}

// One view at the level swept.
struct SweptView {
    const PhotoLevel* level = nullptr;
    Vec3 centre;
    Image<float> grey;
};

int choose_level(const PhotoImages& images, int most_object_px) {
    for (int l = 0; l < images.n_levels(); ++l) {
        std::size_t n_object = 0;
        for (const PhotoView& view : images.views) {
            const auto& rgba = view.levels[at(l)].rgba;
            for (std::size_t i = 3; i < rgba.size(); i += 4) n_object += rgba[i] != 0;
        }
        if (n_object <= at(most_object_px) * images.views.size()) return l;
    }
    return images.n_levels() - 1;
}

std::vector<SweptView> views_at(const PhotoImages& images, int level) {
    std::vector<SweptView> views(images.views.size());
    parallel_for(
        views.size(),
        [&](std::size_t i) {
            const PhotoView& photo = images.views[i];
            views[i] = {&photo.levels[at(level)], photo.centre, brightness(photo.levels[at(level)])};
        },
        1);
    return views;
}

struct Neighbour {
    const SweptView* view = nullptr;
    double angle_rad = 0;
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
        if (angle >= options.min_angle_deg * degree && angle <= options.max_angle_deg * degree)
            neighbours.push_back({&views[i], angle});
    }
    std::stable_sort(neighbours.begin(), neighbours.end(),
                     [](const Neighbour& a, const Neighbour& b) { return a.angle_rad < b.angle_rad; });
    if (neighbours.size() > at(options.n_neighbours)) neighbours.resize(at(options.n_neighbours));
    return neighbours;
}

// How a pixel of the reference view moves in another one as its depth changes: x_other ~ A x_reference + b / depth.
struct Parallax {
    Mat3 A;
    Vec3 b;
};

Parallax parallax(const SweptView& reference, const SweptView& other) {
    const Mat34 &P = reference.level->P, &Q = other.level->P;
    return {Q.leftCols<3>() * P.leftCols<3>().inverse(), Q * reference.centre.homogeneous()};
}

struct Box {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // from (x0, y0) to just before (x1, y1)
    bool is_empty() const { return x0 >= x1 || y0 >= y1; }
    void extend(int x, int y) {
        if (is_empty()) *this = {x, y, x + 1, y + 1};
        *this = {std::min(x0, x), std::min(y0, y), std::max(x1, x + 1), std::max(y1, y + 1)};
    }
};

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
        const Vec3 x = neighbour.view->level->P * middle.homogeneous();
        const double depth = (reference.level->P * middle.homogeneous()).z();
        const Vec3 b = parallax(reference, *neighbour.view).b;
        const Vec2 motion = (b.head<2>() - b.z() * x.hnormalized()) * depth / x.z();
        px_per_inverse_depth = std::max(px_per_inverse_depth, motion.norm());
    }
    return 1.0 / px_per_inverse_depth;
}

PlaneRanges plane_ranges(const SweptView& reference, const VisualHull& hull, double step) {
    constexpr int most_planes = 400;
    std::vector<Vec3> projected;
    projected.reserve(hull.points.size());
    double nearest = 0, farthest = std::numeric_limits<double>::infinity();
    for (const OrientedPoint& point : hull.points) {
        const Vec3 x = reference.level->P * point.position.homogeneous();
        if (!(x.z() > 0)) continue;
        projected.push_back({x.x() / x.z(), x.y() / x.z(), 1.0 / x.z()});
        nearest = std::max(nearest, projected.back().z());
        farthest = std::min(farthest, projected.back().z());
    }
    PlaneRanges ranges;
    const int w = reference.level->width, h = reference.level->height;
    ranges.first = Image<std::int16_t>(w, h, std::numeric_limits<std::int16_t>::max());
    ranges.last = Image<std::int16_t>(w, h, -1);
    if (projected.empty()) return ranges;
    ranges.step = std::max(step, (nearest - farthest) / most_planes);
    ranges.farthest = farthest - ranges.step;
    ranges.n_planes = static_cast<int>(std::ceil((nearest - farthest) / ranges.step)) + 3;
    for (const Vec3& x : projected) {
        const auto plane = static_cast<std::int16_t>(std::lround((x.z() - ranges.farthest) / ranges.step));
        const int px = static_cast<int>(std::lround(std::clamp(x.x(), -2.0, w + 1.0))),
                  py = static_cast<int>(std::lround(std::clamp(x.y(), -2.0, h + 1.0)));
        for (int v = std::max(py - 1, 0); v <= std::min(py + 1, h - 1); ++v)
            for (int u = std::max(px - 1, 0); u <= std::min(px + 1, w - 1); ++u) {
                ranges.first(u, v) = std::min(ranges.first(u, v), plane);
                ranges.last(u, v) = std::max(ranges.last(u, v), static_cast<std::int16_t>(plane + 1));
            }
    }
    return ranges;
}

// Squared correlations of windows around the pixels of a box: of the reference view with another one that a plane has
// carried over. Six sums a window, kept as running sums over columns; only pixels that both images know count.
class WindowCorrelation {
public:
    WindowCorrelation(const Image<float>& reference, const Box& box, int radius)
        : reference_(reference),
          radius_(radius),
          row_pitch_(at(box.x1 - box.x0 + 2 * radius)),
          columns_(n_sums * row_pitch_),
          rows_(n_sums * row_pitch_ * at(2 * radius + 1)),
          windows_(n_sums * at(box.x1 - box.x0)),
          centre_rows_(row_pitch_ * at(2 * radius + 1)) {}

    // Calls take(y, correlations from box.x0 on) for every row of the box, which lies in the one given at the start.
    // @param warped  value of the other image at a pixel of the reference's, unknown where there is none
    template <class Warp, class Take>
    void run(const Box& box, const Warp& warp_row, const Take& take) {
        const int n_rows = 2 * radius_ + 1;
        std::fill(columns_.begin(), columns_.end(), 0.0f);
        std::fill(rows_.begin(), rows_.end(), 0.0f);
        warped_.resize(row_pitch_);
        correlation_.resize(row_pitch_);
        for (int y = box.y0 - radius_; y < box.y1 + radius_; ++y) {
            const int slot = (y - box.y0 + radius_) % n_rows;
            const bool in_image = y >= 0 && y < reference_.height;
            if (in_image)
                warp_row(y, box.x0 - radius_, box.x1 + radius_, warped_.data());
            else
                std::fill(warped_.begin(), warped_.end(), unknown);
            enter_row(y, box, slot);
            const int y_centre = y - radius_;
            if (y_centre < box.y0) continue;
            correlate(box, (slot + n_rows - radius_) % n_rows);
            take(y_centre, correlation_.data());
        }
    }

private:
    enum Sum { n, a, aa, b, bb, ab, n_sums };

    // Replaces the oldest row in the columns' sums.
    void enter_row(int y, const Box& box, int slot) {
        const int width = box.x1 - box.x0 + 2 * radius_;
        float* row = rows_.data() + at(slot) * n_sums * row_pitch_;
        for (std::size_t i = 0; i < n_sums * row_pitch_; ++i) columns_[i] -= row[i];
        float* centre = centre_rows_.data() + at(slot) * row_pitch_;
        for (int i = 0; i < width; ++i) {
            const int x = box.x0 - radius_ + i;
            const float value_a = y >= 0 && y < reference_.height && x >= 0 && x < reference_.width
                                      ? reference_.pixels[at(y) * at(reference_.width) + at(x)]
                                      : unknown;
            const float product = value_a * warped_[at(i)];
            const bool known = product == product;
            const float va = known ? value_a : 0.0f, vb = known ? warped_[at(i)] : 0.0f;
            centre[i] = known ? 1.0f : 0.0f;
            float* r = row + i;
            r[Sum::n * row_pitch_] = centre[i];
            r[Sum::a * row_pitch_] = va;
            r[Sum::aa * row_pitch_] = va * va;
            r[Sum::b * row_pitch_] = vb;
            r[Sum::bb * row_pitch_] = vb * vb;
            r[Sum::ab * row_pitch_] = va * vb;
        }
        for (std::size_t i = 0; i < n_sums * row_pitch_; ++i) columns_[i] += row[i];
    }

    void correlate(const Box& box, int centre_slot) {
        const std::size_t width = at(box.x1 - box.x0);
        for (std::size_t s = 0; s < n_sums; ++s) {
            const float* column = columns_.data() + s * row_pitch_;
            float* window = windows_.data() + s * width;
            for (std::size_t x = 0; x < width; ++x) window[x] = column[x];
            for (std::size_t k = 1; k <= 2 * at(radius_); ++k)
                for (std::size_t x = 0; x < width; ++x) window[x] += column[x + k];
        }
        // Noise of a grey level and a half: a window without more contrast than that says nothing.
        constexpr float noise = 1.5f / 127.5f;
        const auto fewest = 0.5f * static_cast<float>((2 * radius_ + 1) * (2 * radius_ + 1));
        const float* w = windows_.data();
        const float* known = centre_rows_.data() + at(centre_slot) * row_pitch_ + radius_;
        for (std::size_t x = 0; x < width; ++x) {
            const float count = w[Sum::n * width + x], sum_a = w[Sum::a * width + x], sum_b = w[Sum::b * width + x];
            const float floor = count * count * noise * noise;
            const float variance_a = count * w[Sum::aa * width + x] - sum_a * sum_a + floor;
            const float variance_b = count * w[Sum::bb * width + x] - sum_b * sum_b + floor;
            const float covariance = std::max(count * w[Sum::ab * width + x] - sum_a * sum_b, 0.0f);
            const float squared = covariance * covariance / std::max(variance_a * variance_b, 1e-12f);
            correlation_[x] = known[x] > 0.0f && count >= fewest ? squared : 0.0f;
        }
    }

    const Image<float>& reference_;
    int radius_;
    std::size_t row_pitch_;
    std::vector<float> columns_, rows_, windows_, centre_rows_, warped_, correlation_;
};

// The largest values seen at each pixel.
class BestScores {
public:
    BestScores(int n_best, const Box& box)
        : box_(box), pitch_(at(box.x1 - box.x0)), size_(pitch_ * at(box.y1 - box.y0)), best_(at(n_best) * size_) {}

    void clear() { std::fill(best_.begin(), best_.end(), 0.0f); }
    void add_row(int x0, int y, int n, const float* score) {
        const std::size_t start = at(y - box_.y0) * pitch_ + at(x0 - box_.x0);
        for (std::size_t i = 0; i < at(n); ++i) {
            float s = score[i];
            for (std::size_t rank = start + i; rank < best_.size(); rank += size_) {
                const float larger = std::max(best_[rank], s);
                s = std::min(best_[rank], s);
                best_[rank] = larger;
            }
        }
    }
    float mean(int x, int y) const {
        float sum = 0;
        std::size_t n = 0;
        for (std::size_t rank = at(y - box_.y0) * pitch_ + at(x - box_.x0); rank < best_.size(); rank += size_, ++n)
            sum += best_[rank];
        return sum / static_cast<float>(n);
    }

private:
    Box box_;
    std::size_t pitch_, size_;
    std::vector<float> best_;
};

// Pixels of the object that plane k may meet.
std::vector<Box> active_boxes(const MaskImage& mask, const PlaneRanges& ranges) {
    std::vector<Box> boxes(at(ranges.n_planes));
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x)
            if (mask(x, y) != 0)
                for (int k = ranges.first(x, y); k <= ranges.last(x, y); ++k) boxes[at(k)].extend(x, y);
    return boxes;
}

void warp_row(const Parallax& parallax, double inverse_depth, const Image<float>& other, int y, int x0, int x1,
              float* warped) {
    const Vec3 slope = parallax.A.col(0);
    const Vec3 start = parallax.A * Vec3(0, y, 1) + inverse_depth * parallax.b;
    for (int x = x0; x < x1; ++x) {
        const auto z = static_cast<float>(start.z() + x * slope.z());
        const float inverse = 1.0f / z;
        warped[x - x0] = z > 0.0f ? interpolate(other, static_cast<float>(start.x() + x * slope.x()) * inverse,
                                                static_cast<float>(start.y() + x * slope.y()) * inverse)
                                  : unknown;
    }
}

// The costs of all planes that may be the surface.
CostVolume sweep(const SweptView& reference, const std::vector<Neighbour>& neighbours, const PlaneRanges& ranges,
                 const MaskImage& mask, int radius) {
    CostVolume volume(mask.width, mask.height, ranges.n_planes);
    const Box whole{0, 0, mask.width, mask.height};
    WindowCorrelation windows(reference.grey, whole, radius);
    BestScores best((static_cast<int>(neighbours.size()) + 1) / 2, whole);
    std::vector<Parallax> motions;
    for (const Neighbour& neighbour : neighbours) motions.push_back(parallax(reference, *neighbour.view));
    const std::vector<Box> boxes = active_boxes(mask, ranges);
    for (int k = 0; k < ranges.n_planes; ++k) {
        const Box& box = boxes[at(k)];
        if (box.is_empty()) continue;
        best.clear();
        for (std::size_t i = 0; i < neighbours.size(); ++i)
            windows.run(
                box,
                [&](int y, int x0, int x1, float* warped) {
                    warp_row(motions[i], ranges.inverse_depth(k), neighbours[i].view->grey, y, x0, x1, warped);
                },
                [&](int y, const float* correlation) { best.add_row(box.x0, y, box.x1 - box.x0, correlation); });
        for (int y = box.y0; y < box.y1; ++y)
            for (int x = box.x0; x < box.x1; ++x)
                if (mask(x, y) != 0 && k >= ranges.first(x, y) && k <= ranges.last(x, y))
                    volume.costs[volume.first_plane(x, y) + at(k)] = static_cast<std::uint8_t>(
                        (1.0f - std::min(best.mean(x, y), 1.0f)) * CostVolume::worst_cost + 0.5f);
    }
    return volume;
}

// Where the parabola through three values at -1, 0 and 1, the middle one the least, is least.
double parabola_minimum(double before, double least, double after) {
    const double curvature = before - 2.0 * least + after;
    return curvature > 0.0 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0.0;
}

void choose_planes(const CostVolume& volume, const std::vector<std::int16_t>& sums, const MaskImage& mask,
                   const PlaneRanges& ranges, DepthMap& map) {
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x) {
            if (mask(x, y) == 0 || ranges.first(x, y) > ranges.last(x, y)) continue;
            const std::size_t start = volume.first_plane(x, y);
            const std::int16_t* sum = sums.data() + start;
            const auto first = sum + ranges.first(x, y), last = sum + ranges.last(x, y);
            const auto least = std::min_element(first, last + 1);
            const double shift = least > first && least < last ? parabola_minimum(least[-1], least[0], least[1]) : 0.0;
            const auto plane = least - sum;
            map.inverse_depth(x, y) = static_cast<float>(ranges.inverse_depth(static_cast<double>(plane) + shift));
            map.agreement(x, y) = 1.0f - static_cast<float>(volume.costs[start + static_cast<std::size_t>(plane)]) /
                                             CostVolume::worst_cost;
        }
}

DepthMap depth_map(const std::vector<SweptView>& views, std::size_t i, const VisualHull& hull,
                   const SweepOptions& options) {
    const SweptView& reference = views[i];
    const int w = reference.level->width, h = reference.level->height;
    DepthMap map;
    map.P = reference.level->P;
    map.inverse_depth = Image<float>(w, h, 0.0f);
    map.agreement = Image<float>(w, h, 0.0f);
    const Vec3 middle = 0.5 * (hull.lower + hull.upper);
    const auto neighbours = neighbours_of(views, i, middle, options);
    if (neighbours.empty()) return map;

    const PlaneRanges ranges = plane_ranges(reference, hull, plane_step(reference, neighbours, middle));
    map.step = ranges.step;
    MaskImage mask(w, h);
    for (std::size_t p = 0; p < mask.pixels.size(); ++p) mask.pixels[p] = std::isnan(reference.grey.pixels[p]) ? 0 : 1;
    const CostVolume volume = sweep(reference, neighbours, ranges, mask, options.window_radius_px);
    choose_planes(volume, semi_global_sums(volume, mask), mask, ranges, map);
    return map;
}

}  // namespace

std::vector<DepthMap> plane_sweep(const PhotoImages& images, const VisualHull& hull, const SweepOptions& options) {
    const auto views = views_at(images, choose_level(images, options.most_object_px));
    std::vector<DepthMap> maps(views.size());
    parallel_for(
        maps.size(), [&](std::size_t i) { maps[i] = depth_map(views, i, hull, options); }, 1);
    return maps;
}

}  // namespace anyrate
