#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace anyrate {

enum class FrameType : std::uint8_t { base = 0, refine = 1, index = 2, end = 3, colour = 4 };
const char* frame_type_name(FrameType type);

inline constexpr std::size_t frame_header_size = 28;
inline constexpr std::uint8_t frame_flag_new_batch = 0x01;   ///< refine: the face gaps start again
inline constexpr std::uint8_t frame_flag_ancillary = 0x80;   ///< the geometry does not need this frame
inline constexpr std::uint32_t index_sequence = 0xFFFFFFFF;  ///< of an index frame, which is outside of the sequence
inline constexpr std::uint32_t max_splits_per_frame = 2048;

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
    std::uint32_t n_vertices_after = 0;  ///< of index frames 0
};

/// The bytes of a frame: header with size and checksum of the payload, then the payload.
std::vector<std::byte> encode_frame(const FrameInfo& frame, std::span<const std::byte> payload);

/// The frame that starts at bytes[0]; nullopt while it is not whole. `begin` is the offset of bytes[0] in the file.
/// n_vertices_after is left to LogOrder. @throws DecodeError if no frame can start there, or the checksum is wrong
std::optional<FrameInfo> read_frame(std::span<const std::byte> bytes, std::uint64_t begin);

}  // namespace anyrate
