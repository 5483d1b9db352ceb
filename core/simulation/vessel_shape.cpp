#include "core/simulation/vessel_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/simulation/scene_field.h"
#include "core/simulation/vessel_ornament.h"

namespace anyrate {
namespace {

/// The centre line of the handle at x > 0 in the plane y = 0: a Bezier curve from the neck up, out and down to the
/// shoulder, as a chain of short pieces.
constexpr std::size_t n_pieces = 32;
struct CentreLine {
    std::array<Vec2, n_pieces + 1> points;     // (x, z)
    std::array<double, n_pieces + 1> lengths;  // from the start
};
const CentreLine& centre_line() {
    static const CentreLine line = [] {
        const Vec2 a(0.25, 0.68), b(0.70, 0.92), c(0.94, 0.60), d(0.45, 0.22);
        CentreLine result;
        for (std::size_t i = 0; i <= n_pieces; ++i) {
            const double t = static_cast<double>(i) / n_pieces, s = 1 - t;
            result.points[i] = s * s * s * a + 3 * s * s * t * b + 3 * s * t * t * c + t * t * t * d;
            result.lengths[i] = i == 0 ? 0 : result.lengths[i - 1] + (result.points[i] - result.points[i - 1]).norm();
        }
        return result;
    }();
    return line;
}

double handle_field(const Vec3& point) {
    const auto place = on_handle(point);
    if (!place) return 0.1;  // away from the handle, farther than any blend reaches
    return place->distance - 0.046 - 0.012 * strands(*place);
}

double relief(double angle, double z) {
    const Vine frieze = vine(angle, z);
    const double foliage = std::max({0.8 * frieze.stem, frieze.leaf * (1 - 0.35 * frieze.vein), 1.1 * frieze.berry});
    return 0.026 * tongues(angle, z) + 0.026 * beads(angle, z) + 0.020 * foliage + 0.018 * eggs(angle, z) +
           0.020 * mouldings(z) + 0.012 * lip_rope(angle, z);
}

}  // namespace

std::optional<HandlePoint> on_handle(const Vec3& point) {
    const double x = std::abs(point.x()), y = point.y(), z = point.z();
    if (std::abs(y) > 0.16 || x < 0.1 || x > 0.85 || z < 0.05 || z > 1.05) return std::nullopt;
    const CentreLine& line = centre_line();
    const Vec2 p(x, z);
    HandlePoint best{.distance = 1e9, .along = 0, .around = 0};
    for (std::size_t i = 0; i < n_pieces; ++i) {
        const Vec2 piece = line.points[i + 1] - line.points[i];
        const double t = std::clamp((p - line.points[i]).dot(piece) / piece.squaredNorm(), 0.0, 1.0);
        const Vec2 away = p - (line.points[i] + t * piece);
        const double distance = length(away.norm(), y);
        if (distance >= best.distance) continue;
        const double outwards = (piece.x() * away.y() - piece.y() * away.x()) / piece.norm();
        best = {.distance = distance,
                .along = line.lengths[i] + t * piece.norm(),
                .around = std::atan2(point.x() > 0 ? y : -y, outwards)};
    }
    if (best.distance > 0.16) return std::nullopt;
    return best;
}

double strands(const HandlePoint& place) {
    const double across = std::abs(std::sin(1.5 * place.around + 17 * place.along));  // three strands
    return across * (2 - across);
}

double vessel_field(const Vec3& point) {
    const double r = length(point.x(), point.y());
    const double z = point.z();
    const double angle = std::atan2(point.y(), point.x());
    // r - radius overstates the distance to a sloping wall by the secant of its slope.
    const double outside = (r - vessel_radius(z) - relief(angle, z)) / length(1, vessel_slope(z));
    const double body = smooth_max(outside, std::abs(z) - 1, 0.04);
    const double cavity = smooth_max(r - cavity_radius(z), cavity_floor - z, 0.16);
    return smooth_max(smooth_min(body, handle_field(point), 0.04), -cavity, 0.04);
}

}  // namespace anyrate
