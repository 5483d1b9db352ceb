#include "core/reconstruction/view_shifts.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <cstdint>

#include "core/parallel.h"
#include "core/reconstruction/inverse_depth.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

constexpr int n_iterations = 4;
constexpr double most_step_px = 1.0;     // of an iteration, in pixels of the level
constexpr double least_cos = 0.5;        // of the angle under which a view sees a point
constexpr double hidden_px = 2.0;        // behind the nearest surface, in pixels of the depth map
constexpr double usual_residual = 12.0;  // of 255: larger ones count for less
constexpr double least_slope = 1.0;      // of colour, per pixel: an image with less has little to hold on to
constexpr float fewest_views = 3.0F;     // at a point that counts
constexpr int fewest_points = 100;       // of a view that is shifted

// A vertex where a view shows it, by its camera and by its camera and the shift so far.
struct Sighting {
    std::int32_t vertex = 0;
    Vec2 pixel = Vec2::Zero();  // of the level, by the camera
    ColourSample colour{};      // there and a shift further on
    bool has_colour = false;
};

// A view while its shift is looked for.
struct ShiftedView {
    const PhotoLevel* image = nullptr;
    std::vector<Sighting> sightings;
    Vec2 shift = Vec2::Zero();  // pixels of the level

    void look() {
        for (Sighting& s : sightings) {
            const Vec2 x = s.pixel + shift;
            s.has_colour = sample_colour(*image, x.x(), x.y(), s.colour);
        }
    }
};

bool is_within(const PhotoLevel& image, const Vec2& pixel) {
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= image.width - 1 && pixel.y() <= image.height - 1;
}

std::vector<Sighting> sightings(const PhotoView& view, int level, const SurfaceView& surface,
                                const std::vector<Vec3>& normals) {
    const PhotoLevel& image = view.levels[at(level)];
    const Image<float> inverse_depth = render_inverse_depth(without_colours(image), surface);
    const double px = std::ldexp(1.0, level + 1) / view.focal_px;
    std::vector<Sighting> seen;
    for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
        const Vec3& p = surface.vertices[v];
        if (normals[v].dot((view.centre - p).normalized()) < least_cos) continue;
        const Vec3 x = image.P * p.homogeneous();
        if (!(x.z() > 0)) continue;
        Sighting sighting;
        sighting.vertex = static_cast<std::int32_t>(v);
        sighting.pixel = x.hnormalized();
        if (!is_within(image, sighting.pixel)) continue;
        const int column = static_cast<int>((sighting.pixel.x() + 0.5) / 2),
                  row = static_cast<int>((sighting.pixel.y() + 0.5) / 2);
        if (x.z() * inverse_depth(column, row) > 1 + hidden_px * px) continue;
        seen.push_back(sighting);
    }
    return seen;
}

// The colours that all views show of each vertex: their sum, and in the last place their number.
using ColourSums = std::vector<Eigen::Vector4f>;

ColourSums sum_colours(std::span<const ShiftedView> views, std::size_t n_vertices) {
    ColourSums sums(n_vertices, Eigen::Vector4f::Zero());
    for (const ShiftedView& view : views)
        for (const Sighting& s : view.sightings)
            if (s.has_colour) sums[at(s.vertex)] += Eigen::Vector4f(s.colour.c[0], s.colour.c[1], s.colour.c[2], 1.0F);
    return sums;
}

// The Gauss-Newton step towards the mean of what the others show.
Vec2 step_to_others(const ShiftedView& view, const ColourSums& sums) {
    Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
    Vec2 b = Vec2::Zero();
    int n_points = 0;
    for (const Sighting& s : view.sightings) {
        const Eigen::Vector4f& sum = sums[at(s.vertex)];
        if (!s.has_colour || sum[3] < fewest_views) continue;
        ++n_points;
        for (int k = 0; k < 3; ++k) {
            const double of_others = (sum[k] - s.colour.c[k]) / (sum[3] - 1.0F);
            const double residual = s.colour.c[k] - of_others;
            const double relative = residual / usual_residual;
            const double weight = 1 / (1 + relative * relative);
            const Vec2 slope(s.colour.dx[k], s.colour.dy[k]);
            A += weight * slope * slope.transpose();
            b -= weight * residual * slope;
        }
    }
    if (n_points < fewest_points) return Vec2::Zero();
    A.diagonal().array() += 3 * n_points * least_slope * least_slope;
    return A.ldlt().solve(b).cwiseMax(-most_step_px).cwiseMin(most_step_px);
}

// By how many pixels a point moves in a view when it moves by a unit along each axis.
Eigen::Matrix<double, 2, 3> pixels_per_unit(const Mat34& P, const Vec3& point) {
    const Vec3 x = P * point.homogeneous();
    return (P.topLeftCorner<2, 3>() - x.hnormalized() * P.bottomLeftCorner<1, 3>()) / x.z();
}

}  // namespace

std::vector<Vec2> estimate_shifts(const PhotoImages& images, const SurfaceView& surface, int level) {
    const std::vector<Vec3> normals = vertex_normals(surface, OneRings(surface));
    std::vector<ShiftedView> views(images.views.size());
    const auto for_each_view = [&](const auto& body) { parallel_for(views.size(), body, 1); };
    for_each_view([&](std::size_t i) {
        views[i].image = &images.views[i].levels[at(level)];
        views[i].sightings = sightings(images.views[i], level, surface, normals);
    });
    for (int iteration = 0; iteration < n_iterations; ++iteration) {
        for_each_view([&](std::size_t i) { views[i].look(); });
        const ColourSums sums = sum_colours(views, surface.vertices.size());
        for_each_view([&](std::size_t i) { views[i].shift += step_to_others(views[i], sums); });
    }
    std::vector<Vec2> shifts;
    for (const ShiftedView& view : views) shifts.push_back(std::ldexp(1.0, level) * view.shift);
    return shifts;
}

Vec3 take_translation(const PhotoImages& images, const Vec3& point, std::span<Vec2> shifts) {
    const auto for_each_shifted = [&](const auto& body) {
        for (std::size_t i = 0; i < shifts.size(); ++i)
            if (shifts[i] != Vec2(0, 0)) body(shifts[i], pixels_per_unit(images.views[i].levels[0].P, point));
    };
    Mat3 A = Mat3::Zero();
    Vec3 b = Vec3::Zero();
    for_each_shifted([&](const Vec2& shift, const auto& J) {
        A += J.transpose() * J;
        b += J.transpose() * shift;
    });
    // Views that all look along one axis do not say how far things move along it: then they do not move.
    const Vec3 translation = A.completeOrthogonalDecomposition().solve(b);
    for_each_shifted([&](Vec2& shift, const auto& J) { shift -= J * translation; });
    return translation;
}

void shift_views(PhotoImages& images, std::span<const Vec2> shifts) {
    for (std::size_t i = 0; i < shifts.size(); ++i) {
        double scale = 1;
        for (PhotoLevel& level : images.views[i].levels) {
            level.P = with_moved_pixels(level.P, scale * shifts[i]);
            scale /= 2;
        }
    }
}

}  // namespace anyrate
