#include "server/http/bearer.h"

#include "server/http/problem.h"

namespace anyrate {
namespace {

constexpr std::string_view scheme = "Bearer ";

bool equal_in_constant_time(std::string_view given, std::string_view expected) {
    unsigned difference = given.size() == expected.size() ? 0 : 1;
    for (std::size_t i = 0; i < given.size(); ++i)
        difference |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(expected[i % expected.size()]);
    return difference == 0;
}

}  // namespace

void expect_authorized(const Request& request, std::string_view token) {
    if (token.empty() || request.method == "GET" || request.method == "HEAD") return;
    const std::string_view field = request.headers.find("Authorization").value_or("");
    if (field.substr(0, scheme.size()) == scheme && equal_in_constant_time(field.substr(scheme.size()), token)) return;
    throw HttpProblem(401, "writing needs the header field Authorization: Bearer <token>",
                      {{"WWW-Authenticate", "Bearer realm=\"anyrate\""}});
}

}  // namespace anyrate
