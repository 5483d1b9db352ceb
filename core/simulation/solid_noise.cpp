#include "core/simulation/solid_noise.h"

#include <cmath>
#include <numbers>
#include <numeric>

#include "core/simulation/hash.h"

namespace anyrate {
namespace {

/// 6t^5 - 15t^4 + 10t^3: from 0 to 1 with first and second derivatives zero at both ends.
double fade(double t) { return t * t * t * (t * (6 * t - 15) + 10); }

double mix(double a, double b, double t) { return a + t * (b - a); }

Vec3 unit_vector(std::uint64_t bits) {
    const double z = 2 * unit_interval(bits) - 1;
    const double angle = 2 * std::numbers::pi * unit_interval(hash(bits));
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// Twice as fine, turned so that no two octaves share lattice planes: 2 (2 a a^T - I) M with the axis a = (1, 2, 3) /
/// sqrt(14), a half turn, and M a cyclic exchange of the axes.
const Mat3& next_octave() {
    static const Mat3 matrix = [] {
        const Vec3 axis = Vec3(1, 2, 3).normalized();
        Mat3 cycle;
        cycle << 0, 0, 1, 1, 0, 0, 0, 1, 0;
        return Mat3(2 * (2 * axis * axis.transpose() - Mat3::Identity()) * cycle);
    }();
    return matrix;
}

}  // namespace

SolidNoise::SolidNoise(std::uint64_t seed) {
    std::array<std::uint8_t, 256> order;
    std::iota(order.begin(), order.end(), std::uint8_t{0});
    for (std::size_t i = order.size() - 1; i > 0; --i) {
        std::swap(order[i], order[static_cast<std::size_t>(hash(seed, i) % (i + 1))]);
    }
    for (std::size_t i = 0; i < permutation_.size(); ++i) permutation_[i] = order[i % order.size()];
    for (std::size_t i = 0; i < gradients_.size(); ++i) gradients_[i] = unit_vector(hash(seed, 1000 + i));
}

double SolidNoise::corner(int x, int y, int z, const Vec3& offset) const {
    const int index = permutation_[permutation_[permutation_[x & 255] + (y & 255)] + (z & 255)];
    return gradients_[static_cast<std::size_t>(index)].dot(offset);
}

double SolidNoise::operator()(const Vec3& point) const {
    const double fx = std::floor(point.x()), fy = std::floor(point.y()), fz = std::floor(point.z());
    const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
    const double dx = point.x() - fx, dy = point.y() - fy, dz = point.z() - fz;
    const double u = fade(dx), v = fade(dy), w = fade(dz);
    const auto along_x = [&](int j, int k) {
        return mix(corner(x, y + j, z + k, {dx, dy - j, dz - k}), corner(x + 1, y + j, z + k, {dx - 1, dy - j, dz - k}),
                   u);
    };
    const double value = mix(mix(along_x(0, 0), along_x(1, 0), v), mix(along_x(0, 1), along_x(1, 1), v), w);
    return 1.7 * value;  // unit gradients give sqrt(3) / 2 at most; this brings the usual extremes to 1
}

double SolidNoise::fbm(const Vec3& point, int octaves, double gain) const {
    double sum = 0, power = 0, amplitude = 1;
    Vec3 p = point;
    for (int octave = 0; octave < octaves; ++octave) {
        sum += amplitude * (*this)(p);
        power += amplitude * amplitude;
        amplitude *= gain;
        p = next_octave() * p + Vec3(17.3, 5.7, 31.1);
    }
    return sum / std::sqrt(power);
}

}  // namespace anyrate
