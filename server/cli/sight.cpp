#include "server/cli/sight.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mesh/bounds.h"
#include "core/reconstruction/inverse_depth.h"

namespace anyrate {
namespace {

constexpr int depth_size = 300;           // cells of a depth image's longer side
constexpr int samples_per_side = 3;       // of a cell, where its depth is taken
constexpr double tolerance_part = 0.008;  // of the surface's diagonal: about what a cell spans on a slanted face

/// From pixels (convention of camera.h) to an image `scale` times as large, whose pixel (x, y) covers [x, x+1) x [y,
/// y+1).
Mat3 scaled_from_pixels(double scale) {
    Mat3 result = Mat3::Identity();
    result(0, 0) = result(1, 1) = scale;
    result(0, 2) = result(1, 2) = 0.5 * scale;
    return result;
}

/// Smallest depth in every cell of samples_per_side^2 samples of the inverse depth; infinity where there is none.
Image<float> nearest_in_cells(const Image<float>& inverse_depth) {
    Image<float> cells(inverse_depth.width / samples_per_side, inverse_depth.height / samples_per_side,
                       std::numeric_limits<float>::infinity());
    for (int y = 0; y < cells.height * samples_per_side; ++y) {
        for (int x = 0; x < cells.width * samples_per_side; ++x) {
            float& cell = cells(x / samples_per_side, y / samples_per_side);
            if (inverse_depth(x, y) > 0) cell = std::min(cell, 1.0F / inverse_depth(x, y));
        }
    }
    return cells;
}

/// Inverse depth of the surface at the samples of every cell of a camera's depth image.
Image<float> sample_inverse_depth(const Camera& camera, const Mesh& surface, double scale) {
    PhotoLevel level;
    level.width = samples_per_side * static_cast<int>(std::ceil(camera.width * scale));
    level.height = samples_per_side * static_cast<int>(std::ceil(camera.height * scale));
    Mat3 centres_from_corners = Mat3::Identity();
    centres_from_corners(0, 2) = centres_from_corners(1, 2) = -0.5;
    level.P = centres_from_corners * scaled_from_pixels(samples_per_side * scale) * camera.P();
    return render_inverse_depth(level, surface);
}

}  // namespace

std::optional<Sight::DepthView::Hit> Sight::DepthView::project(const Vec3& point) const {
    const Vec3 x = P * point.homogeneous();
    if (!(x.z() > 0)) return std::nullopt;
    const double u = std::floor(x.x() / x.z()), v = std::floor(x.y() / x.z());
    if (!(u >= 0 && v >= 0 && u < depth.width && v < depth.height)) return std::nullopt;
    return Hit{static_cast<int>(u), static_cast<int>(v), static_cast<float>(x.z())};
}

Sight::Sight(const Capture& capture, const Mesh& surface)
    : tolerance_(tolerance_part * bounding_box(surface).diagonal().norm()) {
    for (const View& view : capture.views) {
        const double scale = static_cast<double>(depth_size) / std::max(view.camera.width, view.camera.height);
        views_.push_back({scaled_from_pixels(scale) * view.camera.P(),
                          nearest_in_cells(sample_inverse_depth(view.camera, surface, scale))});
    }
}

int Sight::n_views_of(const Vec3& point) const {
    return static_cast<int>(std::count_if(views_.begin(), views_.end(), [&](const DepthView& view) {
        const auto hit = view.project(point);
        return hit && hit->depth <= view.depth(hit->x, hit->y) + tolerance_;
    }));
}

}  // namespace anyrate
