#include "core/simulation/solid_texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/simulation/scene_field.h"

namespace anyrate {

double Patina::operator()(const Vec3& point) const {
    const double clouds = noise_.fbm(5.0 * point, 2);
    const double grain = noise_.fbm(26.0 * point + Vec3(3.1, 8.7, 1.9), 3, 0.85);
    const double crack = 1 - smooth_step(0.0, 0.045, std::abs(noise_(9.0 * point + Vec3(0.3, 0.2, 0.1) * clouds)));
    const double speck = smooth_step(0.62, 0.80, noise_(48.0 * point));
    return std::exp(0.22 * clouds + 0.75 * grain) * (1 - 0.40 * crack) * (1 - 0.55 * speck);
}

Vec3 ramp(std::initializer_list<Vec3> stops, double t) {
    const double at = std::clamp(t, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(at), stops.size() - 2);
    return blend(stops.begin()[i], stops.begin()[i + 1], at - static_cast<double>(i));
}

SolidTexture veined_stone(std::uint64_t seed) {
    return [noise = SolidNoise(seed), patina = Patina(seed + 1)](const Vec3& p) -> Vec3 {
        const double warp = noise.fbm(2.2 * p, 3);
        const Vec3 stone =
            ramp({{0.10, 0.16, 0.20}, {0.22, 0.36, 0.34}, {0.62, 0.52, 0.34}, {0.60, 0.26, 0.12}}, 0.5 + 0.55 * warp);
        const double vein = 1 - std::abs(std::sin(7.0 * p.dot(Vec3(0.5, 0.4, 0.77)) + 4.0 * warp));
        const Vec3 veined = blend(stone, {0.80, 0.76, 0.66}, 0.85 * smooth_step(0.72, 0.92, vein));
        const double spots = smooth_step(0.25, 0.34, noise.fbm(7.0 * p + Vec3(11, 4, 7), 2));
        return (blend(veined, {0.07, 0.06, 0.10}, 0.8 * spots) * patina(p)).cwiseMin(1.0).cwiseMax(0.01);
    };
}

}  // namespace anyrate
