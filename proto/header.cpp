#include "proto/header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/crc32c.h"

namespace anyrate {

namespace {

constexpr std::array<std::uint8_t, 8> magic = {0x89, 'A', 'R', 'L', 0x0D, 0x0A, 0x1A, 0x0A};
constexpr std::uint16_t this_major = 1, this_minor = 0;
constexpr std::uint8_t rule_id = 1;  // predictor and updates have one rule each so far
constexpr std::size_t max_header_size = 4096;
constexpr std::size_t size_known = 16;  // bytes, the last four of which tell the header's own
constexpr std::size_t flags_offset = 72, crc_offset = 92;
constexpr std::uint32_t flag_sealed = 1;

/// The checksum does not cover itself, but the tail that a later minor version may add.
std::uint32_t header_crc(std::span<const std::byte> header) {
    return crc32c(header.subspan(header_size), crc32c(header.first(crc_offset)));
}

void require(bool holds, const std::string& expectation) {
    if (!holds) throw DecodeError("header: expected " + expectation);
}

void check_limits(const Header& h) {
    require(h.grid.bits >= 1 && h.grid.bits <= 20, "1 to 20 grid bits, got " + std::to_string(h.grid.bits));
    require(h.grid.base_shift >= 0 && h.grid.base_shift < h.grid.bits,
            "a base shift below the grid bits, got " + std::to_string(h.grid.base_shift));
    require(h.grid.origin.allFinite() && std::isfinite(h.grid.unit) && h.grid.unit > 0,
            "a finite origin and a positive unit");
    require(h.rules.step_ratio >= 1 && h.rules.step_ratio <= 65535, "a step ratio of 1 to 65535");
    require(h.n_base_vertices >= 4 && h.n_base_vertices <= std::uint32_t{max_log_vertices},
            "4 to 2^24 base vertices, got " + std::to_string(h.n_base_vertices));
    require(h.n_base_faces >= 4 && h.n_base_faces <= 2 * std::uint32_t{max_log_vertices} && h.n_base_faces % 2 == 0,
            "4 to 2^25 base faces, an even number, got " + std::to_string(h.n_base_faces));
    const auto is_step = [](int step) { return step >= 1 && step <= 255; };
    require(is_step(h.colour_steps.luma) && is_step(h.colour_steps.chroma), "colour steps of 1 to 255");
}

std::vector<std::byte> with_crc(std::vector<std::byte> header) {
    ByteWriter crc;
    crc.put(header_crc(header));
    std::copy(crc.bytes().begin(), crc.bytes().end(), header.begin() + crc_offset);
    return header;
}

}  // namespace

std::vector<std::byte> encode_header(const Header& header) {
    check_limits(header);
    ByteWriter out;
    out.put(std::as_bytes(std::span(magic)));
    out.put(this_major);
    out.put(this_minor);
    out.put(static_cast<std::uint32_t>(header_size));
    out.put(header.log_id);
    for (int axis = 0; axis < 3; ++axis) out.put(header.grid.origin[axis]);
    out.put(header.grid.unit);
    out.put(static_cast<std::uint8_t>(header.grid.bits));
    out.put(static_cast<std::uint8_t>(header.grid.base_shift));
    out.put(rule_id);
    out.put(static_cast<std::uint8_t>(header.rules.flip_rule));
    out.put(static_cast<std::uint8_t>(header.rules.ring_smoothing));
    out.put(rule_id);
    out.put(static_cast<std::uint16_t>(header.rules.step_ratio));
    out.put(header.n_base_vertices);
    out.put(header.n_base_faces);
    out.put(header.sealed ? flag_sealed : std::uint32_t{0});
    out.put(static_cast<std::uint8_t>(header.colour_steps.luma));
    out.put(static_cast<std::uint8_t>(header.colour_steps.chroma));
    out.pad_to(header_size);
    return with_crc(out.take());
}

std::size_t header_bytes_needed(std::span<const std::byte> bytes) {
    const auto start = bytes.first(std::min(bytes.size(), magic.size()));
    require(std::ranges::equal(start, std::as_bytes(std::span(magic)).first(start.size())),
            "the magic bytes 89 'ARL' of a log");
    require(bytes.size() >= size_known, std::to_string(header_size) + " bytes, got " + std::to_string(bytes.size()));
    ByteReader in(bytes.subspan(magic.size()), "header");
    const auto major = in.take<std::uint16_t>();
    require(major == this_major, "major version 1, got " + std::to_string(major) + ": a newer reader is needed");
    in.take<std::uint16_t>();
    const auto size = in.take<std::uint32_t>();
    require(size >= header_size && size <= max_header_size, "96 to 4096 header bytes, got " + std::to_string(size));
    return size;
}

Header decode_header(std::span<const std::byte> bytes) {
    const std::size_t size = header_bytes_needed(bytes);
    require(bytes.size() >= size, std::to_string(size) + " bytes, got " + std::to_string(bytes.size()));
    bytes = bytes.first(size);
    ByteReader crc(bytes.subspan(crc_offset), "header");
    require(crc.take<std::uint32_t>() == header_crc(bytes), "another checksum: the header is damaged");

    ByteReader in(bytes.subspan(magic.size()), "header");
    Header header;
    header.major = in.take<std::uint16_t>();
    header.minor = in.take<std::uint16_t>();
    header.header_bytes = in.take<std::uint32_t>();
    header.log_id = in.take<std::uint64_t>();
    for (int axis = 0; axis < 3; ++axis) header.grid.origin[axis] = in.take<double>();
    header.grid.unit = in.take<double>();
    header.grid.bits = in.take<std::uint8_t>();
    header.grid.base_shift = in.take<std::uint8_t>();
    const auto take_rule = [&in](const std::string& rule, std::uint8_t last_known) {
        const auto id = in.take<std::uint8_t>();
        const std::string known = last_known == 1 ? " 1" : " 1 to " + std::to_string(last_known);
        require(id >= 1 && id <= last_known, rule + known + ", got " + std::to_string(id));
        return id;
    };
    take_rule("predictor", rule_id);
    header.rules.flip_rule = FlipRule{take_rule("flip rule", 3)};
    header.rules.ring_smoothing = RingSmoothing{take_rule("smoothing", 2)};
    take_rule("update mode", rule_id);
    header.rules.step_ratio = in.take<std::uint16_t>();
    header.n_base_vertices = in.take<std::uint32_t>();
    header.n_base_faces = in.take<std::uint32_t>();
    header.sealed = (in.take<std::uint32_t>() & flag_sealed) != 0;
    header.colour_steps.luma = in.take<std::uint8_t>();
    header.colour_steps.chroma = in.take<std::uint8_t>();
    check_limits(header);
    return header;
}

std::vector<std::byte> sealed_header(std::span<const std::byte> header) {
    header = header.first(decode_header(header).header_bytes);
    std::vector<std::byte> sealed(header.begin(), header.end());
    sealed[flags_offset] |= std::byte{flag_sealed};
    return with_crc(std::move(sealed));
}

}  // namespace anyrate
