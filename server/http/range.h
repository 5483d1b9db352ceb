#pragma once
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

namespace anyrate {

/// Bytes [begin, end) of a representation.
struct ByteRange {
    std::uint64_t begin = 0, end = 0;
    friend bool operator==(const ByteRange&, const ByteRange&) = default;
};
struct WholeBody {
    friend bool operator==(const WholeBody&, const WholeBody&) = default;
};
struct Unsatisfiable {
    friend bool operator==(const Unsatisfiable&, const Unsatisfiable&) = default;
};
using RangeAnswer = std::variant<WholeBody, ByteRange, Unsatisfiable>;

/// What a Range field asks of a body of `size` bytes (RFC 9110, 14.1.2 and 14.2): one range `a-b`, `a-` or the suffix
/// `-n`. Another unit, several ranges and what is no range at all are ignored, as the RFC allows: the whole body.
RangeAnswer parse_range(std::string_view field, std::uint64_t size);

/// Whether an entity tag is named in an If-None-Match field (RFC 9110, 13.1.2: weak comparison, `*` matches any).
bool matches_etag(std::string_view field, std::string_view etag);

/// Whether an If-Range field lets the range stand (RFC 9110, 13.1.5: strong comparison; a date never matches here).
bool if_range_holds(std::string_view field, std::string_view etag);

}  // namespace anyrate
