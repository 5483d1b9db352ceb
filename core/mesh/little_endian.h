#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <vector>

namespace anyrate {

/// Appends the bytes of a number, least significant first, whatever the machine's own order.
template <class Number>
void put_little_endian(std::vector<std::byte>& bytes, Number value) {
    auto raw = std::bit_cast<std::array<std::byte, sizeof(Number)>>(value);
    if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
    bytes.insert(bytes.end(), raw.begin(), raw.end());
}

}  // namespace anyrate
