#include "server/cli/sight.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mesh/bounds.h"
#include "core/mesh/surface_samples.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

constexpr int depth_size = 300;           // cells of a depth image's longer side
constexpr int n_samples = 800'000;        // of the surface: about ten in every cell that it covers
constexpr double tolerance_part = 0.008;  // of the surface's diagonal: about what a cell spans on a slanted face

/// The camera's projection to cells, depth_size of them along the longer side of the image.
Mat34 cells_from_world(const Camera& camera) {
    const double scale = static_cast<double>(depth_size) / std::max(camera.width, camera.height);
    Mat3 cells_from_pixels = Mat3::Identity();
    cells_from_pixels(0, 0) = cells_from_pixels(1, 1) = scale;
    cells_from_pixels(0, 2) = cells_from_pixels(1, 2) = 0.5 * scale;  // a pixel's centre is half a pixel inside
    return cells_from_pixels * camera.P();
}

Image<float> empty_depth(const Camera& camera) {
    const double scale = static_cast<double>(depth_size) / std::max(camera.width, camera.height);
    return {static_cast<int>(std::ceil(camera.width * scale)), static_cast<int>(std::ceil(camera.height * scale)),
            std::numeric_limits<float>::infinity()};
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
    for (const View& view : capture.views) views_.push_back({cells_from_world(view.camera), empty_depth(view.camera)});
    const std::vector<Vec3> points = sample_surface(surface, n_samples, 1);
    parallel_for(
        views_.size(),
        [&](std::size_t i) {
            DepthView& view = views_[i];
            for (const Vec3& point : points) {
                const auto hit = view.project(point);
                if (hit) view.depth(hit->x, hit->y) = std::min(view.depth(hit->x, hit->y), hit->depth);
            }
        },
        1);
}

int Sight::n_views_of(const Vec3& point) const {
    return static_cast<int>(std::count_if(views_.begin(), views_.end(), [&](const DepthView& view) {
        const auto hit = view.project(point);
        return hit && hit->depth <= view.depth(hit->x, hit->y) + tolerance_;
    }));
}

}  // namespace anyrate
