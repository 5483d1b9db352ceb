#include "server/http/range.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>

using namespace anyrate;

namespace {
const RangeAnswer whole = WholeBody{};
const RangeAnswer unsatisfiable = Unsatisfiable{};
RangeAnswer bytes(std::uint64_t begin, std::uint64_t end) { return ByteRange{begin, end}; }
}  // namespace

TEST_CASE("Range: first and last position are both included") {
    CHECK(parse_range("bytes=0-0", 10) == bytes(0, 1));
    CHECK(parse_range("bytes=2-5", 10) == bytes(2, 6));
}

TEST_CASE("Range: an end beyond the body is cut to it") {
    CHECK(parse_range("bytes=2-99", 10) == bytes(2, 10));
    CHECK(parse_range("bytes=2-99999999999999999999999", 10) == bytes(2, 10));
    CHECK(parse_range("bytes=2-", 10) == bytes(2, 10));
}

TEST_CASE("Range: a suffix counts from the end") {
    CHECK(parse_range("bytes=-3", 10) == bytes(7, 10));
    CHECK(parse_range("bytes=-30", 10) == bytes(0, 10));
    CHECK(parse_range("bytes=-0", 10) == unsatisfiable);
}

TEST_CASE("Range: a start behind the body is not satisfiable") {
    CHECK(parse_range("bytes=10-", 10) == unsatisfiable);
    CHECK(parse_range("bytes=0-", 0) == unsatisfiable);
    CHECK(parse_range("bytes=99999999999999999999999-", 10) == unsatisfiable);
}

TEST_CASE("Range: what is no single byte range is ignored") {
    for (const char* field : {"", "bytes", "bytes=", "bytes=-", "bytes=a-b", "bytes=5-2", "bytes=1-2,4-5", "lines=1-2",
                              "bytes=1-2x", "bytes=+1-2", "bytes=--1"}) {
        CAPTURE(field);
        CHECK(parse_range(field, 10) == whole);
    }
}

TEST_CASE("Range: every range of a small body is the bytes it names") {
    const std::uint64_t size = 7;
    for (std::uint64_t a = 0; a < size; ++a)
        for (std::uint64_t b = a; b < size + 2; ++b)
            CHECK(parse_range("bytes=" + std::to_string(a) + "-" + std::to_string(b), size) ==
                  bytes(a, std::min(b + 1, size)));
}

TEST_CASE("If-None-Match: a list, a weak tag and a star match") {
    CHECK(matches_etag("\"a\"", "\"a\""));
    CHECK(matches_etag("\"x\", W/\"a\"", "\"a\""));
    CHECK(matches_etag(" * ", "\"a\""));
    CHECK_FALSE(matches_etag("\"b\", \"aa\"", "\"a\""));
}

TEST_CASE("If-Range: only the strong tag itself holds") {
    CHECK(if_range_holds("\"a\"", "\"a\""));
    CHECK_FALSE(if_range_holds("W/\"a\"", "\"a\""));
    CHECK_FALSE(if_range_holds("Sat, 01 Jan 2026 00:00:00 GMT", "\"a\""));
}
