#include "core/reconstruction/sampling.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace anyrate {
namespace {

std::vector<LatticeSample> make_lattice(int M) {
    std::vector<LatticeSample> samples;
    samples.reserve(static_cast<std::size_t>((M + 1) * (M + 2) / 2));
    for (int i = 0; i <= M; ++i)
        for (int j = 0; j <= i; ++j) {
            const double m = static_cast<double>(i) / M;
            const double n = i == 0 ? 0.0 : static_cast<double>(j) / i;
            // Nghiem et al., Eq. 6.
            LatticeSample s{{1 - m, m * (1 - n), m * n}, 1.0, -1};
            const bool on_edge = j == 0 || j == i || i == M;
            if (i == 0) s.corner = 0;
            if (i == M && j == 0) s.corner = 1;
            if (i == M && j == M) s.corner = 2;
            s.weight = s.corner >= 0 ? 0.0 : on_edge ? 0.5 : 1.0;
            samples.push_back(s);
        }
    return samples;
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

}  // namespace anyrate
