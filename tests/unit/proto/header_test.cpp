#include <doctest/doctest.h>

#include <limits>
#include <utility>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/crc32c.h"
#include "proto/header.h"
#include "tests/golden/sample_models.h"

namespace anyrate {
namespace {

Header sample_header() {
    Header header;
    header.log_id = 0xFEDCBA9876543210;
    header.grid = samples::unit_grid(14);
    header.grid.origin = Vec3(-1.5, 2.25, 1e6);
    header.rules.step_ratio = 80;
    header.n_base_vertices = 2502;
    header.n_base_faces = 5000;
    return header;
}

/// A header with one byte changed and its checksum made right again.
std::vector<std::byte> with_byte(std::vector<std::byte> bytes, std::size_t offset, std::uint8_t value) {
    bytes[offset] = std::byte{value};
    ByteWriter crc;
    crc.put(crc32c(std::span(bytes).subspan(96), crc32c(std::span(bytes).first(92))));
    std::copy(crc.bytes().begin(), crc.bytes().end(), bytes.begin() + 92);
    return bytes;
}

}  // namespace

TEST_CASE("CRC-32C: the check value of the standard, in one piece and in two") {
    const std::string digits = "123456789";
    const auto bytes = std::as_bytes(std::span(digits));
    CHECK(crc32c(bytes) == 0xE3069283u);
    CHECK(crc32c(bytes.subspan(4), crc32c(bytes.first(4))) == 0xE3069283u);
}

TEST_CASE("Header: decoding gives back what was encoded") {
    const Header header = sample_header();
    const std::vector<std::byte> bytes = encode_header(header);
    REQUIRE(bytes.size() == header_size);
    const Header decoded = decode_header(bytes);
    CHECK(decoded.log_id == header.log_id);
    CHECK(decoded.grid == header.grid);
    CHECK(decoded.rules == header.rules);
    CHECK(decoded.n_base_vertices == 2502);
    CHECK(decoded.n_base_faces == 5000);
    CHECK(decoded.colour_steps == header.colour_steps);
    CHECK_FALSE(decoded.sealed);
}

TEST_CASE("Header: every truncation and every flipped bit is rejected") {
    const std::vector<std::byte> bytes = encode_header(sample_header());
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        CHECK_THROWS_AS(decode_header(std::vector(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))),
                        DecodeError);
    }
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        auto damaged = bytes;
        damaged[bit / 8] ^= std::byte{1} << (bit % 8);
        CHECK_THROWS_AS(decode_header(damaged), DecodeError);
    }
}

TEST_CASE("Header: fields out of their limits are rejected though the checksum is right") {
    const std::vector<std::byte> bytes = encode_header(sample_header());
    REQUIRE_NOTHROW(decode_header(with_byte(bytes, 10, 7)));                  // a minor version to come
    REQUIRE_NOTHROW(decode_header(with_byte(bytes, 80, 7)));                  // a reserved byte
    CHECK_THROWS_AS(decode_header(with_byte(bytes, 8, 2)), DecodeError);      // major version
    CHECK_THROWS_AS(decode_header(with_byte(bytes, 12, 95)), DecodeError);    // header bytes
    CHECK_THROWS_AS(decode_header(with_byte(bytes, 55, 0x80)), DecodeError);  // negative unit
    CHECK_THROWS_AS(decode_header(with_byte(bytes, 56, 21)), DecodeError);    // grid bits
    CHECK_THROWS_AS(decode_header(with_byte(bytes, 57, 14)), DecodeError);    // base shift
    for (const auto& [rule, unknown] : {std::pair(58, 2), std::pair(59, 4), std::pair(60, 3), std::pair(61, 2)}) {
        for (const int id : {0, unknown, 255}) {
            const auto bad = with_byte(bytes, static_cast<std::size_t>(rule), static_cast<std::uint8_t>(id));
            CHECK_THROWS_AS(decode_header(bad), DecodeError);
        }
    }
    CHECK_THROWS_AS(decode_header(with_byte(bytes, 67, 2)), DecodeError);  // V0 beyond 2^24
    CHECK_THROWS_AS(decode_header(with_byte(bytes, 68, 3)), DecodeError);  // F0 odd
    CHECK_THROWS_AS(decode_header(with_byte(bytes, 76, 0)), DecodeError);  // luma step
}

TEST_CASE("Header: every known flip rule and smoothing is read as it was written") {
    for (const FlipRule flips : {FlipRule::delaunay, FlipRule::crease_preserving, FlipRule::curvature_aligned}) {
        for (const RingSmoothing smoothing : {RingSmoothing::quarter, RingSmoothing::sixteenth}) {
            Header header = sample_header();
            header.rules.flip_rule = flips;
            header.rules.ring_smoothing = smoothing;
            CHECK(decode_header(encode_header(header)).rules == header.rules);
        }
    }
}

TEST_CASE("Header: a tail of a later minor version is skipped, but its bytes are checked") {
    std::vector<std::byte> bytes = encode_header(sample_header());
    bytes.resize(104, std::byte{0x55});
    bytes = with_byte(bytes, 12, 104);
    CHECK(decode_header(bytes).header_bytes == 104);
    CHECK(decode_header(sealed_header(bytes)).header_bytes == 104);
    bytes[100] = std::byte{0x54};
    CHECK_THROWS_AS(decode_header(bytes), DecodeError);
}

TEST_CASE("Header: sealing changes the flag and the checksum, nothing else") {
    const std::vector<std::byte> live = encode_header(sample_header());
    const std::vector<std::byte> sealed = sealed_header(live);
    CHECK(decode_header(sealed).sealed);
    for (std::size_t i = 0; i < 92; ++i) CHECK((live[i] == sealed[i]) == (i != 72));
}

TEST_CASE("Header: a grid that is no number is not encoded") {
    Header header = sample_header();
    header.grid.unit = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(encode_header(header), DecodeError);
}

}  // namespace anyrate
