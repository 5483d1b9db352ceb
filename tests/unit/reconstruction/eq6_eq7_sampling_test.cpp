#include "core/reconstruction/sampling.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>

using namespace anyrate;

TEST_CASE("Eq. 6: the lattice of M steps has (M+1)(M+2)/2 samples, barycentric coordinates of the triangle") {
    for (int M = 1; M <= max_lattice_steps; ++M) {
        const auto samples = lattice(M);
        REQUIRE(static_cast<int>(samples.size()) == (M + 1) * (M + 2) / 2);
        for (const LatticeSample& s : samples) {
            CHECK(s.b[0] + s.b[1] + s.b[2] == doctest::Approx(1.0));
            CHECK(std::min({s.b[0], s.b[1], s.b[2]}) >= -1e-12);
        }
    }
}

TEST_CASE("Eq. 6: the lattice is regular: every sample stands on a multiple of 1/M") {
    for (int M : {1, 2, 5, 13})
        for (const LatticeSample& s : lattice(M))
            for (double b : s.b) CHECK(std::abs(b * M - std::round(b * M)) < 1e-9);
}

TEST_CASE("Eq. 6: the three corners are samples, each once") {
    for (int M : {1, 2, 9}) {
        int seen[3] = {0, 0, 0};
        for (const LatticeSample& s : lattice(M))
            if (s.corner >= 0) {
                ++seen[s.corner];
                CHECK(s.b[s.corner] == 1.0);
            }
        for (int n : seen) CHECK(n == 1);
    }
}

TEST_CASE("Eq. 8: edge samples weigh a half, inner ones one, and their sum is the lattice's area in samples") {
    // M^2 / 2 cells' worth of samples without the corners' share: (M-1)(M-2)/2 inside and 3 (M-1) halves.
    for (int M : {1, 2, 3, 10}) {
        double sum = 0;
        for (const LatticeSample& s : lattice(M)) sum += s.weight;
        CHECK(sum == doctest::Approx((M - 1) * (M - 2) / 2.0 + 1.5 * (M - 1)));
    }
}

TEST_CASE("Eq. 7: M = sqrt(2 C A) gives about C samples per pixel") {
    for (double area : {20.0, 100.0, 500.0})
        for (double C : {0.5, 1.0, 2.0}) {
            const int M = lattice_steps(area, C);
            CHECK(M == std::lround(std::sqrt(2 * C * area)));
            // Counted by weight with 1/6 for a corner of a regular mesh, a lattice of M steps has M^2 / 2 samples.
            CHECK(M * M / 2.0 == doctest::Approx(C * area).epsilon(0.25));
        }
}

TEST_CASE("Eq. 7: a triangle that no view sees still gets its corners, and no triangle more than the table holds") {
    CHECK(lattice_steps(0.0, 1.0) == 1);
    CHECK(lattice_steps(1e9, 1.0) == max_lattice_steps);
}

namespace {

std::int64_t n_samples(std::span<const double> areas_px, std::span<const int> steps) {
    std::int64_t n = 0;
    for (std::size_t f = 0; f < steps.size(); ++f)
        if (areas_px[f] > 0) n += static_cast<std::int64_t>(lattice(steps[f]).size());
    return n;
}

}  // namespace

TEST_CASE("Eq. 7: uniform sampling has one number of steps, and no other comes nearer to the adaptive total") {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> area(0.0, 90.0);
    std::vector<double> areas_px(500);
    for (double& a : areas_px) a = std::max(0.0, area(random) - 10);  // some are not seen
    for (double C : {0.1, 0.5, 1.0, 3.0}) {
        const auto adaptive = lattice_steps(areas_px, C, Sampling::adaptive);
        const auto uniform = lattice_steps(areas_px, C, Sampling::uniform);
        for (std::size_t f = 0; f < areas_px.size(); ++f) {
            CHECK(adaptive[f] == lattice_steps(areas_px[f], C));
            CHECK(uniform[f] == uniform[0]);
        }
        const std::int64_t wanted = n_samples(areas_px, adaptive);
        const std::int64_t off = std::abs(n_samples(areas_px, uniform) - wanted);
        for (int M = 1; M <= max_lattice_steps; ++M) {
            const std::vector<int> other(areas_px.size(), M);
            CHECK(off <= std::abs(n_samples(areas_px, other) - wanted));
        }
    }
}

TEST_CASE("Eq. 7: where all triangles are alike, uniform sampling is adaptive sampling") {
    const std::vector<double> areas_px(20, 31.0);
    CHECK(lattice_steps(areas_px, 1.0, Sampling::uniform) == lattice_steps(areas_px, 1.0, Sampling::adaptive));
}

TEST_CASE("Eq. 7: a surface that no view sees is sampled uniformly at its corners alone") {
    const std::vector<double> areas_px(4, 0.0);
    CHECK(lattice_steps(areas_px, 1.0, Sampling::uniform) == std::vector<int>(4, 1));
    CHECK(lattice_steps(std::vector<double>{}, 1.0, Sampling::uniform).empty());
}
