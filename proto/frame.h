#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace anyrate {

enum class FrameType : std::uint8_t { base = 0, refine = 1, index = 2, end = 3, colour = 4 };
const char* frame_type_name(FrameType type);

inline constexpr std::size_t frame_header_size = 28;

/// The 28 bytes in front of every payload (proto/FORMAT.md, "Frame"), and where it stands.
struct FrameInfo {
    FrameType type = FrameType::base;
    std::uint8_t flags = 0;
    std::uint32_t payload_bytes = 0;
    std::uint32_t sequence = 0;
    std::uint32_t n_vertices_before = 0;
    std::uint32_t n_splits = 0;
    std::uint32_t state_hash = 0;
    std::uint64_t begin = 0;  ///< offset of the frame header in the file
    std::uint64_t end() const { return begin + frame_header_size + payload_bytes; }
    std::uint32_t n_vertices_after = 0;
};

}  // namespace anyrate
