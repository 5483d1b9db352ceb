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

}  // namespace anyrate
