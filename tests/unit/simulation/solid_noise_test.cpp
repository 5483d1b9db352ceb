#include "core/simulation/solid_noise.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/simulation/hash.h"

namespace anyrate {
namespace {

Vec3 random_point(std::uint64_t i) {
    const auto coordinate = [&](std::uint64_t axis) { return 200 * unit_interval(hash(7, 3 * i + axis)) - 100; };
    return {coordinate(0), coordinate(1), coordinate(2)};
}

}  // namespace

TEST_CASE("Solid noise: zero at the lattice points, within its bounds elsewhere, and zero on average") {
    const SolidNoise noise(5);
    CHECK(noise({3, -7, 12}) == 0);
    constexpr int n = 20'000;
    double sum = 0, squares = 0;
    for (int i = 0; i < n; ++i) {
        const double value = noise(random_point(static_cast<std::uint64_t>(i)));
        REQUIRE(std::abs(value) <= 1.5);
        sum += value;
        squares += value * value;
    }
    const double deviation = std::sqrt(squares / n);
    CHECK(deviation > 0.2);
    CHECK(std::abs(sum / n) < 4 * deviation / std::sqrt(n));
}

TEST_CASE("Solid noise: its second derivative does not jump where lattice cells meet") {
    const SolidNoise noise(5);
    const double h = 1e-4;
    for (std::uint64_t i = 0; i < 50; ++i) {
        Vec3 p = random_point(i);
        p.x() = std::round(p.x());
        const auto curvature = [&](double at) {
            const Vec3 middle = p + Vec3(at, 0, 0), step(h, 0, 0);
            return (noise(middle + step) - 2 * noise(middle) + noise(middle - step)) / (h * h);
        };
        // Third derivatives are about 100 at most: over 4 h they change the second by that times 4 h.
        CHECK(std::abs(curvature(2 * h) - curvature(-2 * h)) < 0.1);
    }
}

TEST_CASE("Solid noise: another seed gives another noise, the same seed the same") {
    const Vec3 p(0.3, 0.4, 0.7);
    CHECK(SolidNoise(1)(p) == SolidNoise(1)(p));
    CHECK(SolidNoise(1)(p) != SolidNoise(2)(p));
}

TEST_CASE("Solid noise: the fractal sum is about as strong as one octave") {
    const SolidNoise noise(9);
    double one = 0, sum = 0;
    for (std::uint64_t i = 0; i < 5000; ++i) {
        one += std::pow(noise(random_point(i)), 2);
        sum += std::pow(noise.fbm(random_point(i), 4), 2);
    }
    CHECK(std::sqrt(sum / one) == doctest::Approx(1).epsilon(0.1));
}

TEST_CASE("Near normal: mean 0 and variance 1") {
    constexpr int n = 100'000;
    double sum = 0, squares = 0;
    for (std::uint64_t i = 0; i < n; ++i) {
        const double x = near_normal(hash(3, i));
        sum += x;
        squares += x * x;
    }
    CHECK(std::abs(sum / n) < 4 / std::sqrt(n));
    CHECK(squares / n == doctest::Approx(1).epsilon(0.02));
}

}  // namespace anyrate
