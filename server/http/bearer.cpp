#include "server/http/bearer.h"

#include "server/http/problem.h"

namespace anyrate {
namespace {

constexpr std::string_view scheme = "Bearer ";

bool is_reading(const Request& request) { return request.method == "GET" || request.method == "HEAD"; }

bool is_open_to_all(const Request& request) {
    return is_reading(request) && (request.path == "/healthz" || request.path == "/readyz");
}

}  // namespace

void expect_authorized(const Request& request, const AccessRules& rules) {
    const Scope scope = is_reading(request) ? Scope::read : Scope::write;
    if (is_open_to_all(request) || (scope == Scope::read && !rules.is_private)) return;
    // A server without a writer listens on loopback only, and there everybody may write.
    if (!rules.is_private && !rules.is_beyond_loopback && !rules.tokens.has_writer()) return;
    const std::string_view field = request.headers.find("Authorization").value_or("");
    if (field.substr(0, scheme.size()) == scheme) {
        const std::string_view token = field.substr(scheme.size());
        if (rules.tokens.permit(token, scope)) return;
        if (rules.tokens.permit(token, Scope::read)) throw HttpProblem(403, "this token may read, not write");
    }
    throw HttpProblem(401,
                      std::string(scope == Scope::read ? "reading" : "writing") +
                          " needs the header field Authorization: Bearer <token>",
                      {{"WWW-Authenticate", "Bearer realm=\"anyrate\""}});
}

}  // namespace anyrate
