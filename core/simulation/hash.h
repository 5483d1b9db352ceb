#pragma once
// Randomness as a function: what belongs to a pixel, a lattice point or a camera is drawn from its own number, so that
// the order of the work and the number of threads do not matter.
#include <cstdint>

namespace anyrate {

/// A bijection of 64-bit numbers that looks random: one step of the SplitMix64 generator.
/// Source: Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators", Figure 17.
inline std::uint64_t hash(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
    x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
    return x ^ (x >> 31);
}
inline std::uint64_t hash(std::uint64_t seed, std::uint64_t x) { return hash(hash(seed) ^ x); }

/// Uniform in [0, 1), from the upper 53 bits.
inline double unit_interval(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

/// Near-normal with mean 0 and variance 1: the sum of four 16-bit uniforms. Exact arithmetic up to one scaling, hence
/// the same on every machine, which libm's logarithm does not promise; never beyond 3.5 standard deviations.
inline double near_normal(std::uint64_t bits) {
    const auto sum = static_cast<double>((bits & 0xffff) + ((bits >> 16) & 0xffff) + ((bits >> 32) & 0xffff) +
                                         ((bits >> 48) & 0xffff));
    constexpr double mean = 2.0 * 0xffff;
    constexpr double deviation = 37837.2;  // sqrt(4 (2^32 - 1) / 12)
    return (sum - mean) / deviation;
}

}  // namespace anyrate
