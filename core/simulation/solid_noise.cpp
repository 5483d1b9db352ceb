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

std::array<double, 3> unit_vector(std::uint64_t bits) {
    const double z = 2 * unit_interval(bits) - 1;
    const double angle = 2 * std::numbers::pi * unit_interval(hash(bits));
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
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

// Plain numbers instead of vectors from here on: this is the innermost loop of every rendered sample.

double SolidNoise::corner(int x, int y, int z, double dx, double dy, double dz) const {
    const unsigned row = permutation_[static_cast<unsigned>(x) & 255u] + (static_cast<unsigned>(y) & 255u);
    const unsigned cell = permutation_[row] + (static_cast<unsigned>(z) & 255u);
    const auto& gradient = gradients_[permutation_[cell]];
    return gradient[0] * dx + gradient[1] * dy + gradient[2] * dz;
}

double SolidNoise::at(double px, double py, double pz) const {
    const double fx = std::floor(px), fy = std::floor(py), fz = std::floor(pz);
    const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
    const double dx = px - fx, dy = py - fy, dz = pz - fz;
    const double u = fade(dx), v = fade(dy), w = fade(dz);
    const auto along_x = [&](int j, int k) {
        return mix(corner(x, y + j, z + k, dx, dy - j, dz - k), corner(x + 1, y + j, z + k, dx - 1, dy - j, dz - k), u);
    };
    const double value = mix(mix(along_x(0, 0), along_x(1, 0), v), mix(along_x(0, 1), along_x(1, 1), v), w);
    return 1.7 * value;  // unit gradients give sqrt(3) / 2 at most; this brings the usual extremes to 1
}

double SolidNoise::operator()(const Vec3& point) const { return at(point.x(), point.y(), point.z()); }

double SolidNoise::fbm(const Vec3& point, int octaves, double gain) const {
    double sum = 0, power = 0, amplitude = 1;
    double x = point.x(), y = point.y(), z = point.z();
    for (int octave = 0; octave < octaves; ++octave) {
        sum += amplitude * at(x, y, z);
        power += amplitude * amplitude;
        amplitude *= gain;
        // Twice as fine, moved, and turned so that no lattice planes coincide: the axes exchanged in turn, then the
        // half turn about (1, 2, 3), which is 2 a a^T - I with the unit axis a; all entries times two.
        constexpr double s = 2.0 / 7;
        const double nx = s * (2 * x + 3 * y - 6 * z) + 17.3;
        const double ny = s * (-3 * x + 6 * y + 2 * z) + 5.7;
        z = s * (6 * x + 2 * y + 3 * z) + 31.1;
        x = nx;
        y = ny;
    }
    return sum / std::sqrt(power);
}

}  // namespace anyrate
