#include "core/reconstruction/sampling.h"

#include <doctest/doctest.h>

#include <cmath>

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
