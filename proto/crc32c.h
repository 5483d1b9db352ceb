#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace anyrate {

/// CRC-32C (Castagnoli) of several byte strings one behind the other: crc32c(b, crc32c(a)) is that of a followed by b.
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t crc_before = 0);

}  // namespace anyrate
