#include "core/simulation/vessel_ornament.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

#include "core/simulation/scene_field.h"

namespace anyrate {
namespace {

using std::numbers::pi;

struct Knot {
    double z, r;
};
constexpr std::array<Knot, 19> outside{{{-1.00, 0.285},
                                        {-0.965, 0.315},
                                        {-0.92, 0.300},
                                        {-0.87, 0.205},
                                        {-0.80, 0.160},
                                        {-0.73, 0.200},
                                        {-0.55, 0.395},
                                        {-0.30, 0.545},
                                        {-0.05, 0.605},
                                        {0.13, 0.590},
                                        {0.28, 0.525},
                                        {0.40, 0.425},
                                        {0.48, 0.350},
                                        {0.56, 0.305},
                                        {0.68, 0.285},
                                        {0.80, 0.305},
                                        {0.90, 0.365},
                                        {0.96, 0.405},
                                        {1.00, 0.410}}};
constexpr std::array<Knot, 8> inside{{{0.10, 0.260},
                                      {0.30, 0.300},
                                      {0.48, 0.268},
                                      {0.62, 0.232},
                                      {0.74, 0.232},
                                      {0.86, 0.275},
                                      {0.95, 0.330},
                                      {1.00, 0.345}}};

/// A smooth curve through the knots (cubic Hermite, tangents from the neighbouring knots), constant beyond the ends.
struct Curve {
    double value, slope;
};
Curve through(std::span<const Knot> knots, double z) {
    if (z <= knots.front().z) return {knots.front().r, 0};
    if (z >= knots.back().z) return {knots.back().r, 0};
    const auto above = std::upper_bound(knots.begin(), knots.end(), z, [](double x, const Knot& k) { return x < k.z; });
    const auto i = static_cast<std::size_t>(above - knots.begin()) - 1;
    const auto tangent = [&](std::size_t k) {
        if (k == 0 || k + 1 == knots.size()) return 0.0;
        return (knots[k + 1].r - knots[k - 1].r) / (knots[k + 1].z - knots[k - 1].z);
    };
    const double length = knots[i + 1].z - knots[i].z;
    const double t = (z - knots[i].z) / length;
    const double rise = knots[i + 1].r - knots[i].r;
    const double m0 = tangent(i) * length, m1 = tangent(i + 1) * length;
    const double c2 = 3 * rise - 2 * m0 - m1, c3 = m0 + m1 - 2 * rise;
    return {knots[i].r + t * (m0 + t * (c2 + t * c3)), (m0 + t * (2 * c2 + 3 * t * c3)) / length};
}

/// Signed angle to the nearest of n directions spread evenly around the axis, the first at `phase`.
double to_nearest(double angle, int n, double phase = 0) {
    const double step = 2 * pi / n;
    const double turns = (angle - phase) / step;
    return (turns - std::round(turns)) * step;
}

/// A ridge around the vessel: 1 at its crest.
double ridge(double z, double crest, double width) {
    const double t = (z - crest) / width;
    return std::exp(-t * t);
}

/// A round knob: 1 on top, 0 from its edge on. Its sides are not too steep for the lattice it will be carved from.
double knob(double distance, double radius) { return std::max(1 - distance * distance / (radius * radius), 0.0); }

constexpr int n_waves = 8;
constexpr double wave_height = 0.062;

/// A leaf of five lobes, its tip along +v; (u, v) from its middle, world lengths.
void add_leaf(Vine& vine, double u, double v) {
    constexpr double size = 0.098;
    const double distance = length(u, v);
    if (distance > size) return;
    const double lobes = std::cos(5 * std::atan2(u, v));
    const double edge = size * (0.76 + 0.24 * lobes);
    vine.leaf = std::max(vine.leaf, 1 - smooth_step(0.60, 1.0, distance / edge));
    vine.vein = std::max(vine.vein, smooth_step(0.95, 0.99, lobes) * (1 - smooth_step(0.6, 0.9, distance / edge)));
}

/// Six berries in a triangle that hangs along -v, on a common ground, so that no deep pits are left between them.
void add_berries(Vine& vine, double u, double v) {
    constexpr double radius = 0.023;
    vine.berry = std::max(vine.berry, 0.5 * knob(length(u, v - 0.6 * radius), 2.8 * radius));
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k <= 2 - row; ++k) {
            const double cu = (2 * k - (2 - row)) * radius, cv = (1 - row) * 1.75 * radius;
            vine.berry = std::max(vine.berry, knob(length(u - cu, v - cv), radius));
        }
    }
}

}  // namespace

double vessel_radius(double z) { return through(outside, z).value; }
double vessel_slope(double z) { return through(outside, z).slope; }
double cavity_radius(double z) { return through(inside, z).value; }

double tongues(double angle, double z) {
    const auto& [low, high] = vessel_zone::tongues;
    if (z < low || z > high) return 0;
    const double across = std::abs(std::sin(0.5 * n_tongues * angle));  // 0 in the groove, 1 on the spine
    const double tip = high - 0.02 - 0.05 * (1 - across) * (1 - across);
    return across * (2 - across) * window(low, tip, 0.035, z);
}

double beads(double angle, double z) {
    constexpr int n_beads = 48;
    const double middle = vessel_zone::beads.middle();
    if (std::abs(z - middle) > 0.04) return 0;
    return knob(length(to_nearest(angle, n_beads) * vessel_radius(middle), z - middle), 0.031);
}

Vine vine(double angle, double z) {
    Vine result;
    if (!vessel_zone::frieze.contains(z)) return result;
    const double height = z - vessel_zone::frieze.middle();
    const double radius = vessel_radius(z);
    const double wave = wave_height * std::sin(n_waves * angle);
    const double slope = wave_height * n_waves * std::cos(n_waves * angle) / radius;
    result.stem = 1 - smooth_step(0.006, 0.024, std::abs(height - wave) / length(1, slope));
    // Bays open downwards below a crest of the wave and upwards above a trough.
    const double from_crest = to_nearest(angle, n_waves, 0.5 * pi / n_waves) * radius;
    const double from_trough = to_nearest(angle, n_waves, 1.5 * pi / n_waves) * radius;
    add_leaf(result, from_crest, -(height + 0.054));
    add_leaf(result, from_trough, height - 0.054);
    const double from_rise = to_nearest(angle, n_waves, 0) * radius;
    const double from_fall = to_nearest(angle, n_waves, pi / n_waves) * radius;
    add_berries(result, from_rise, -(height - 0.096));
    add_berries(result, from_fall, height + 0.096);
    return result;
}

double eggs(double angle, double z) {
    const auto& [low, high] = vessel_zone::eggs;
    if (z < low || z > high) return 0;
    const double half_width = 0.40 * 2 * pi / n_eggs * vessel_radius(z);
    const double across = to_nearest(angle, n_eggs) * vessel_radius(z);
    // Straight sides above, a half circle below. The shoulder is steep: lengths along it are longer than in z.
    const double below = std::max(low + 0.055 - z, 0.0) * 1.3;
    const double edge = length(across, below) - half_width;
    return smooth_step(0, 0.022, -edge) * (1 - smooth_step(high - 0.03, high, z));
}

double mouldings(double z) {
    return ridge(z, -0.865, 0.016) + 0.9 * ridge(z, -0.74, 0.016) + 0.55 * ridge(z, -0.331, 0.011) +
           0.55 * ridge(z, -0.228, 0.011) + 0.6 * ridge(z, 0.122, 0.012) + 0.6 * ridge(z, 0.283, 0.012) +
           1.1 * ridge(z, 0.485, 0.020) + 0.8 * ridge(z, 0.805, 0.014);
}

double lip_rope(double angle, double z) {
    return (0.5 + 0.5 * std::cos(40 * angle + 60 * z)) * smooth_step(0.915, 0.945, z);
}

}  // namespace anyrate
