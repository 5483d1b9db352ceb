#include "server/http/problem.h"

#include <doctest/doctest.h>

#include <new>
#include <stdexcept>
#include <string>

#include "core/error.h"

using namespace anyrate;

namespace {
template <class Error>
HttpProblem problem_of(const Error& error) {
    return to_problem(std::make_exception_ptr(error));
}
}  // namespace

TEST_CASE("Problem: each type of exception has its status") {
    CHECK(problem_of(HttpProblem(416, "outside")).status == 416);
    CHECK(problem_of(InputError("bad")).status == 400);
    CHECK(problem_of(DecodeError("bad")).status == 400);
    CHECK(problem_of(IoError("disk")).status == 503);
    CHECK(problem_of(std::bad_alloc()).status == 500);
}

TEST_CASE("Problem: what failed inside is not told outside") {
    const HttpProblem problem = problem_of(std::runtime_error("/home/secret"));
    CHECK(std::string(problem.what()).find("secret") == std::string::npos);
}

TEST_CASE("Problem: the document names status, phrase and sentence") {
    const Response response = problem_response({404, "there is no model \"x\""});
    CHECK(response.status == 404);
    CHECK(response.headers.find("content-type") == "application/problem+json");
    CHECK(std::get<std::string>(response.body) ==
          "{\"type\":\"about:blank\",\"title\":\"Not Found\",\"status\":404,\"detail\":\"there is no model "
          "\\\"x\\\"\"}\n");
}
