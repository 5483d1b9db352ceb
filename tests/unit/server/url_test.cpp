#include "server/client/url.h"

#include <doctest/doctest.h>

#include <string>

#include "core/error.h"
#include "server/client/log_target.h"

using namespace anyrate;

TEST_CASE("Url: host, port and target") {
    const Url url = parse_url("http://example.org:8080/a/b?c=d#e");
    CHECK(url.host == "example.org");
    CHECK(url.port == "8080");
    CHECK(url.target == "/a/b?c=d");
    CHECK(path_of(url) == "/a/b");
    CHECK(parse_url("http://h").target == "/");
    CHECK(parse_url("http://h?x").target == "/?x");
    CHECK(parse_url("http://[::1]:9/").host == "::1");
    CHECK(parse_url("http://[::1]:9/").authority() == "[::1]:9");
}

TEST_CASE("Url: https has a port of its own") {
    const Url url = parse_url("https://example.org/a");
    CHECK(url.is_secure);
    CHECK(url.port == "443");
    CHECK(url.authority() == "example.org");
    CHECK(parse_url("https://h:8443").authority() == "h:8443");
    CHECK(parse_url("https://h:80").authority() == "h:80");
    CHECK(parse_url("http://h:443").authority() == "h:443");
    CHECK_FALSE(parse_url("http://h").is_secure);
}

TEST_CASE("Url: what is no http address is refused") {
    for (const char* text : {"", "ftp://h/", "https:/h/", "https://", "h:80", "http://", "http://:80/", "http://u@h/",
                             "http://h:x/", "http://h:/", "http://h:123456/"})
        CHECK_THROWS_AS(parse_url(text), InputError);
}

TEST_CASE("Fetch: a model's log and index stand below it, a file's index beside it") {
    const std::string model = "/v1/models/" + std::string(26, 'a');
    CHECK(log_target(model) == model + "/log");
    CHECK(index_target(model + "/log") == model + "/index?form=live");
    CHECK(log_target("/files/vessel.arl") == "/files/vessel.arl");
    CHECK(index_target("/files/vessel.arl") == "/files/vessel.arl.idx");
}
