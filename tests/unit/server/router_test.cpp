#include "server/http/router.h"

#include <doctest/doctest.h>

#include <string>

#include "server/http/problem.h"

using namespace anyrate;

namespace {

Router sample_router() {
    const auto say = [](const char* word) { return [word](const Request&) { return Response{.body = word}; }; };
    return Router({{"GET", "/", say("root")},
                   {"GET", "/models", say("list")},
                   {"POST", "/models", say("make")},
                   {"GET", "/models/{id}", say("show")},
                   {"GET", "/models/{id}/log", say("log")}});
}

std::string found(const std::string& method, const std::string& path, std::string* id = nullptr) {
    Request request{.method = method, .path = path};
    try {
        const Router router = sample_router();
        const Response response = router.find(request).handle(request);
        if (id) *id = request.captured["id"];
        return std::get<std::string>(response.body);
    } catch (const HttpProblem& problem) {
        return std::to_string(problem.status) + " " + std::string(problem.headers.find("allow").value_or(""));
    }
}

}  // namespace

TEST_CASE("Router: a path and method find their handler") {
    CHECK(found("GET", "/") == "root");
    CHECK(found("POST", "/models") == "make");
    CHECK(found("HEAD", "/models") == "list");
    CHECK(found("GET", "/models/x/log") == "log");
}

TEST_CASE("Router: a name captures one segment") {
    std::string id;
    CHECK(found("GET", "/models/some-id", &id) == "show");
    CHECK(id == "some-id");
}

TEST_CASE("Router: unknown paths are 404") {
    for (const char* path : {"/x", "/models/", "/models/a/b", "/models/a/log/", "//models", "/MODELS", ""})
        CHECK_MESSAGE(found("GET", path) == "404 ", path);
}

TEST_CASE("Router: a known path with another method is 405 and says what is allowed") {
    CHECK(found("PUT", "/models") == "405 GET, HEAD, POST");
    CHECK(found("POST", "/models/a") == "405 GET, HEAD");
}
