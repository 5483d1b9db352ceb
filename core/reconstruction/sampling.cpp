#include "core/reconstruction/sampling.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace anyrate {
namespace {

/// Value at a sample of the hat function that the middle of edge (a, a + 1) gets by a 1-to-4 split.
double middle_hat(const LatticeSample& s, std::size_t a) {
    const double first = s.b[a], second = s.b[(a + 1) % 3], opposite = s.b[(a + 2) % 3];
    if (opposite >= 0.5) return 0.0;
    if (first >= 0.5) return 2 * second;
    if (second >= 0.5) return 2 * first;
    return 1 - 2 * opposite;
}

std::vector<LatticeSample> make_lattice(int M) {
    std::vector<LatticeSample> samples;
    samples.reserve(static_cast<std::size_t>((M + 1) * (M + 2) / 2));
    for (int i = 0; i <= M; ++i)
        for (int j = 0; j <= i; ++j) {
            const double m = static_cast<double>(i) / M;
            const double n = i == 0 ? 0.0 : static_cast<double>(j) / i;
            // Nghiem et al., Eq. 6.
            LatticeSample s{{1 - m, m * (1 - n), m * n}, 1.0, -1, {}, {}};
            const bool on_edge = j == 0 || j == i || i == M;
            if (i == 0) s.corner = 0;
            if (i == M && j == 0) s.corner = 1;
            if (i == M && j == M) s.corner = 2;
            s.weight = s.corner >= 0 ? 0.0 : on_edge ? 0.5 : 1.0;
            for (std::size_t a = 0; a < 3; ++a) {
                s.b_single[a] = static_cast<float>(s.b[a]);
                s.middle[a] = static_cast<float>(middle_hat(s, a));
            }
            samples.push_back(s);
        }
    return samples;
}

std::int64_t n_points(int M) { return static_cast<std::int64_t>(M + 1) * (M + 2) / 2; }

/// The steps for which the triangles that are seen have most nearly as many points as with `steps`.
int uniform_steps(std::span<const double> mean_areas_px, std::span<const int> steps) {
    std::int64_t n_seen = 0, n_adaptive = 0;
    for (std::size_t f = 0; f < steps.size(); ++f)
        if (mean_areas_px[f] > 0) {
            ++n_seen;
            n_adaptive += n_points(steps[f]);
        }
    const auto off = [&](int M) { return std::abs(n_seen * n_points(M) - n_adaptive); };
    int best = 1;
    for (int M = 2; M <= max_lattice_steps; ++M)
        if (off(M) < off(best)) best = M;
    return best;
}

}  // namespace

std::span<const LatticeSample> lattice(int M) {
    static const auto lattices = [] {
        std::array<std::vector<LatticeSample>, max_lattice_steps + 1> all;
        for (int steps = 1; steps <= max_lattice_steps; ++steps)
            all[static_cast<std::size_t>(steps)] = make_lattice(steps);
        return all;
    }();
    assert(M >= 1 && M <= max_lattice_steps);
    return lattices[static_cast<std::size_t>(M)];
}

int lattice_steps(double mean_area_px, double C) {
    // Nghiem et al., Eq. 7.
    const double M = std::sqrt(2.0 * C * mean_area_px);
    return std::clamp(static_cast<int>(std::lround(M)), 1, max_lattice_steps);
}

std::vector<int> lattice_steps(std::span<const double> mean_areas_px, double C, Sampling sampling) {
    std::vector<int> steps(mean_areas_px.size());
    std::transform(mean_areas_px.begin(), mean_areas_px.end(), steps.begin(),
                   [C](double area_px) { return lattice_steps(area_px, C); });
    if (sampling == Sampling::uniform) std::fill(steps.begin(), steps.end(), uniform_steps(mean_areas_px, steps));
    return steps;
}

}  // namespace anyrate
