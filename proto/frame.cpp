#include "proto/frame.h"

#include <cassert>
#include <string>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/crc32c.h"

namespace anyrate {

namespace {

constexpr std::uint16_t sync_word = 0x4C50;
constexpr std::size_t crc_offset = 24;
constexpr std::uint32_t max_payload_bytes = 1u << 26;
constexpr std::uint32_t max_refine_payload_bytes = 1u << 20;

[[noreturn]] void fail(std::uint64_t begin, const std::string& expectation) {
    throw DecodeError("frame at offset " + std::to_string(begin) + ": expected " + expectation);
}

void check_limits(const FrameInfo& frame) {
    const bool is_refine = frame.type == FrameType::refine;
    const std::uint32_t limit = is_refine ? max_refine_payload_bytes : max_payload_bytes;
    if (frame.payload_bytes > limit) {
        fail(frame.begin,
             "at most " + std::to_string(limit) + " payload bytes, got " + std::to_string(frame.payload_bytes));
    }
    if (is_refine && (frame.n_splits < 1 || frame.n_splits > max_splits_per_frame)) {
        fail(frame.begin, "1 to 2048 splits, got " + std::to_string(frame.n_splits));
    }
}

}  // namespace

const char* frame_type_name(FrameType type) {
    switch (type) {
        case FrameType::base:
            return "base";
        case FrameType::refine:
            return "refine";
        case FrameType::index:
            return "index";
        case FrameType::end:
            return "end";
        case FrameType::colour:
            return "colour";
    }
    return "unknown";
}

std::vector<std::byte> encode_frame(const FrameInfo& frame, std::span<const std::byte> payload) {
    assert(payload.size() <= max_payload_bytes);
    ByteWriter out;
    out.put(sync_word);
    out.put(static_cast<std::uint8_t>(frame.type));
    out.put(frame.flags);
    out.put(static_cast<std::uint32_t>(payload.size()));
    out.put(frame.sequence);
    out.put(frame.n_vertices_before);
    out.put(frame.n_splits);
    out.put(frame.state_hash);
    out.put(crc32c(payload, crc32c(out.bytes())));
    out.put(payload);
    return out.take();
}

std::optional<FrameInfo> read_frame(std::span<const std::byte> bytes, std::uint64_t begin) {
    if (bytes.size() < frame_header_size) return std::nullopt;
    ByteReader in(bytes, "frame");
    if (in.take<std::uint16_t>() != sync_word) fail(begin, "the sync bytes 50 4C");
    FrameInfo frame;
    frame.begin = begin;
    frame.type = static_cast<FrameType>(in.take<std::uint8_t>());
    frame.flags = in.take<std::uint8_t>();
    frame.payload_bytes = in.take<std::uint32_t>();
    frame.sequence = in.take<std::uint32_t>();
    frame.n_vertices_before = in.take<std::uint32_t>();
    frame.n_splits = in.take<std::uint32_t>();
    frame.state_hash = in.take<std::uint32_t>();
    const auto crc = in.take<std::uint32_t>();
    check_limits(frame);
    if (frame.payload_bytes > in.remaining()) return std::nullopt;
    if (crc != crc32c(in.take_bytes(frame.payload_bytes), crc32c(bytes.first(crc_offset)))) {
        fail(begin, "another checksum: the frame is damaged");
    }
    return frame;
}

}  // namespace anyrate
