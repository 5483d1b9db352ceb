#include "server/http/multipart.h"

#include <doctest/doctest.h>

#include <string>

#include "server/http/problem.h"
#include "server/store/file.h"

using namespace anyrate;

namespace {

const std::string body =
    "--xx\r\nContent-Disposition: form-data; name=\"images\"; filename=\"a \\\"b\\\".png\"\r\nContent-Type: "
    "image/png\r\n\r\n"
    "one\r\n--x\r\ntwo\r\n--xx\r\n\r\nno header\r\n--xx--\r\n";

}  // namespace

TEST_CASE("Multipart: parts are the bytes between boundaries, with what their headers say") {
    const auto parts = parse_multipart(as_bytes(body), "xx");
    REQUIRE(parts.size() == 2);
    CHECK(parts[0].name == "images");
    CHECK(parts[0].filename == "a \"b\".png");
    CHECK(parts[0].content_type == "image/png");
    CHECK(as_text(parts[0].bytes) == "one\r\n--x\r\ntwo");
    CHECK(as_text(parts[1].bytes) == "no header");
    CHECK(parts[1].name.empty());
}

TEST_CASE("Multipart: every truncation is refused") {
    const std::size_t end = body.size() - 2;  // the last line's end may be left out
    for (std::size_t n = 0; n < end; ++n)
        CHECK_THROWS_AS(parse_multipart(as_bytes(std::string_view(body).substr(0, n)), "xx"), HttpProblem);
    CHECK(parse_multipart(as_bytes(std::string_view(body).substr(0, end)), "xx").size() == 2);
}

TEST_CASE("Multipart: a boundary is one that the standard allows") {
    CHECK(multipart_boundary("multipart/form-data; charset=utf-8; Boundary=\"a b\"") == "a b");
    CHECK(multipart_boundary("multipart/form-data; boundary=----WebKitFormBoundary7") == "----WebKitFormBoundary7");
    for (const std::string bad : {"", "; boundary=", "; boundary=\"a", "; boundary=\"a \"", "; boundary=a\tb\x01"})
        CHECK_THROWS_AS(multipart_boundary("multipart/form-data" + bad), HttpProblem);
    CHECK_THROWS_AS(multipart_boundary("multipart/form-data; boundary=" + std::string(71, 'a')), HttpProblem);
}
