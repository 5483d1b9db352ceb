#include "core/reconstruction/confirmed_depth.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/parallel.h"

namespace anyrate {
namespace {

// From the pixels of a map to the world.
class BackProjection {
public:
    explicit BackProjection(const DepthMap& map)
        : world_from_pixel_(map.P.leftCols<3>().inverse()), centre_(-world_from_pixel_ * map.P.col(3)) {}

    Vec3 operator()(double x, double y, double inverse_depth) const {
        return centre_ + world_from_pixel_ * Vec3(x, y, 1.0) / inverse_depth;
    }

private:
    Mat3 world_from_pixel_;
    Vec3 centre_;
};

bool sees_at_its_depth(const DepthMap& map, const Vec3& point, double tolerance_px) {
    const Vec3 x = map.P * point.homogeneous();
    if (!(x.z() > 0)) return false;
    const double u = x.x() / x.z(), v = x.y() / x.z();
    const auto& known = map.inverse_depth;
    if (!(u >= 0 && v >= 0 && u < known.width - 1 && v < known.height - 1)) return false;
    const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
    // Any of the four pixels around: on a slanted surface their depths differ by more than the tolerance.
    for (int i = 0; i < 4; ++i) {
        const double inverse_depth = known(x0 + (i & 1), y0 + (i >> 1));
        if (inverse_depth > 0 && std::abs(inverse_depth - 1.0 / x.z()) <= tolerance_px * map.step) return true;
    }
    return false;
}

DepthMap confirm(std::span<const DepthMap> maps, std::size_t own, const ConfirmOptions& options) {
    DepthMap result = maps[own];
    if (!(result.step > 0)) return result;
    const BackProjection to_world(result);
    for (int y = 0; y < result.inverse_depth.height; ++y)
        for (int x = 0; x < result.inverse_depth.width; ++x) {
            float& inverse_depth = result.inverse_depth(x, y);
            if (!(inverse_depth > 0)) continue;
            int n_confirm = 0;
            if (result.agreement(x, y) >= options.least_agreement) {
                const Vec3 point = to_world(x, y, inverse_depth);
                for (std::size_t i = 0; i < maps.size() && n_confirm < options.n_views; ++i)
                    n_confirm += i != own && sees_at_its_depth(maps[i], point, options.tolerance_px);
            }
            if (n_confirm < options.n_views) inverse_depth = 0.0f;
        }
    return result;
}

}  // namespace

std::vector<DepthMap> confirm_depths(std::span<const DepthMap> maps, const ConfirmOptions& options) {
    std::vector<DepthMap> confirmed(maps.size());
    parallel_for(
        maps.size(), [&](std::size_t i) { confirmed[i] = confirm(maps, i, options); }, 1);
    return confirmed;
}

std::vector<OrientedPoint> surface_points(const DepthMap& map) {
    constexpr int radius = 2, fewest = 10;
    constexpr double largest_jump_px = 4.0;  // of disparity, on one surface within the window
    std::vector<OrientedPoint> points;
    if (!(map.step > 0)) return points;
    const BackProjection to_world(map);
    // Of the parallelepiped of a ray and its changes from pixel to pixel, at depth one.
    const double pixel_volume = 1.0 / std::abs(map.P.leftCols<3>().determinant());
    const auto& known = map.inverse_depth;
    for (int y = radius; y + radius < known.height; ++y)
        for (int x = radius; x + radius < known.width; ++x) {
            if (!(known(x, y) > 0)) continue;
            // A plane of the world is linear in inverse depth: w = plane . (x, y, 1); here around (x, y), in steps.
            Mat3 A = Mat3::Zero();
            Vec3 b = Vec3::Zero();
            int n = 0;
            for (int dy = -radius; dy <= radius; ++dy)
                for (int dx = -radius; dx <= radius; ++dx) {
                    const float w = known(x + dx, y + dy);
                    const double steps = (w - known(x, y)) / map.step;
                    if (!(w > 0) || std::abs(steps) > largest_jump_px) continue;
                    const Vec3 place(dx, dy, 1.0);
                    A += place * place.transpose();
                    b += steps * place;
                    ++n;
                }
            if (n < fewest || std::abs(A.determinant()) < 1.0) continue;
            const Vec3 fit = map.step * A.ldlt().solve(b);
            const double inverse_depth = known(x, y) + fit.z();
            if (!(inverse_depth > 0)) continue;
            const Vec3 plane(fit.x(), fit.y(), inverse_depth - fit.x() * x - fit.y() * y);
            // Seen from the camera's centre that plane of the world is q . X = 1: q points away from the camera, and
            // its length is the inverse of the distance to the plane.
            const Vec3 q = map.P.leftCols<3>().transpose() * plane;
            OrientedPoint point;
            point.position = to_world(x, y, inverse_depth);
            point.normal = -q.normalized();
            point.area = pixel_volume * q.norm() / std::pow(inverse_depth, 3.0);
            points.push_back(point);
        }
    return points;
}

}  // namespace anyrate
