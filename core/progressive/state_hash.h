#pragma once
#include <cstdint>

namespace anyrate {

/// A rolling 32-bit hash, one multiplication a word (proto/FORMAT.md, "State hash"). Each step is a bijection of the
/// hash for a given word and of the word for a given hash, so a single differing word always shows.
class RollingHash {
public:
    void mix(std::uint32_t word) {
        value_ = (value_ ^ word) * 0x9E3779B1u;
        value_ ^= value_ >> 15;
    }
    void mix(std::int32_t word) { mix(static_cast<std::uint32_t>(word)); }
    std::uint32_t value() const { return value_; }

private:
    std::uint32_t value_ = 0;
};

}  // namespace anyrate
