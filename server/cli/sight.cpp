#include "server/cli/sight.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/reconstruction/visibility.h"

namespace anyrate {
namespace {

constexpr int depth_size_px = 300;        // longer side: what is thinner than a cell is of no weight in a mean
constexpr double tolerance_part = 0.008;  // of the surface's diagonal: about what a cell spans on a slanted face

/// `camera` with its longer image side shrunk to depth_size_px, without pixels.
PhotoLevel small_level(const Camera& camera) {
    const double scale = static_cast<double>(depth_size_px) / std::max(camera.width, camera.height);
    Mat3 small_from_full = Mat3::Identity();
    small_from_full(0, 0) = small_from_full(1, 1) = scale;
    small_from_full(0, 2) = small_from_full(1, 2) = 0.5 * scale - 0.5;  // the corner stays at (-0.5, -0.5)
    PhotoLevel level;
    level.width = static_cast<int>(std::ceil(camera.width * scale));
    level.height = static_cast<int>(std::ceil(camera.height * scale));
    level.P = small_from_full * camera.P();
    return level;
}

double diagonal(const Mesh& mesh) {
    Eigen::AlignedBox3d box;
    for (const Vec3& vertex : mesh.vertices) box.extend(vertex);
    return box.diagonal().norm();
}

}  // namespace

Sight::Sight(const Capture& capture, const Mesh& surface) : tolerance_(tolerance_part * diagonal(surface)) {
    for (const View& view : capture.views) {
        const PhotoLevel level = small_level(view.camera);
        views_.push_back({level.P, render_depth(level, surface)});
    }
}

int Sight::n_views_of(const Vec3& point) const {
    return static_cast<int>(std::count_if(views_.begin(), views_.end(), [&](const DepthView& view) {
        const Vec3 x = view.P * point.homogeneous();
        if (!(x.z() > 0)) return false;
        const double u = std::round(x.x() / x.z()), v = std::round(x.y() / x.z());
        if (!(u >= 0 && v >= 0 && u < view.depth.width && v < view.depth.height)) return false;
        return x.z() <= view.depth(static_cast<int>(u), static_cast<int>(v)) + tolerance_;
    }));
}

}  // namespace anyrate
