#include "server/http/target.h"

#include <doctest/doctest.h>

#include <string>

#include "server/http/problem.h"

using namespace anyrate;

namespace {
int status_of(const std::string& target) {
    try {
        parse_target(target);
        return 200;
    } catch (const HttpProblem& problem) {
        return problem.status;
    }
}
}  // namespace

TEST_CASE("Target: path and query are decoded") {
    const Target target = parse_target("/v1/a%20b?x=1%2B2&y=a+b&z");
    CHECK(target.path == "/v1/a b");
    CHECK(target.query.at("x") == "1+2");
    CHECK(target.query.at("y") == "a b");
    CHECK(target.query.at("z").empty());
}

TEST_CASE("Target: scheme and host, as a proxy's client names them, are passed over") {
    CHECK(parse_target("http://a.example:80/v1/models?limit=2").path == "/v1/models");
    CHECK(parse_target("https://a.example").path == "/");
    CHECK(status_of("ftp://a.example/") == 400);
    CHECK(status_of("*") == 400);
}

TEST_CASE("Target: what could mean another file is refused") {
    for (const char* target : {"/a%2fb", "/a%2Fb", "/a%00", "", "*", "/a%", "/a%4", "/a%zz", "/?a=%"})
        CHECK_MESSAGE(status_of(target) == 400, target);
}

TEST_CASE("Target: a parameter may stand once") { CHECK(status_of("/?a=1&a=2") == 400); }

TEST_CASE("Target: more than 4096 bytes are too long") {
    CHECK(status_of("/" + std::string(4095, 'x')) == 200);
    CHECK(status_of("/" + std::string(4096, 'x')) == 414);
}
