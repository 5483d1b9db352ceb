#include "server/http/bearer.h"

#include "server/http/problem.h"

namespace anyrate {
namespace {

constexpr std::string_view scheme = "Bearer ";
constexpr std::string_view protocol_scheme = "anyrate.bearer.";

bool is_reading(const Request& request) { return request.method == "GET" || request.method == "HEAD"; }

/// The viewer asks for the token, so it must be there without one; it says nothing of any model.
bool is_viewer(std::string_view path) {
    return path == "/" || path.starts_with("/models/") || path.starts_with("/assets/");
}

bool is_open_to_all(const Request& request, const AccessRules& rules) {
    if (!is_reading(request)) return false;
    return request.path == "/healthz" || request.path == "/readyz" || (rules.has_viewer && is_viewer(request.path));
}

std::string_view trimmed(std::string_view text) {
    while (text.starts_with(' ') || text.starts_with('\t')) text.remove_prefix(1);
    while (text.ends_with(' ') || text.ends_with('\t')) text.remove_suffix(1);
    return text;
}

std::string_view protocol_token(const Request& request) {
    if (!request.path.ends_with("/live")) return {};
    for (std::string_view list = request.headers.find("Sec-WebSocket-Protocol").value_or(""); !list.empty();) {
        const std::string_view protocol = trimmed(list.substr(0, list.find(',')));
        if (protocol.starts_with(protocol_scheme)) return protocol.substr(protocol_scheme.size());
        const std::size_t comma = list.find(',');
        list = comma == list.npos ? std::string_view() : list.substr(comma + 1);
    }
    return {};
}

std::string_view token_of(const Request& request) {
    const auto field = request.headers.find("Authorization");
    if (!field) return protocol_token(request);
    return field->starts_with(scheme) ? field->substr(scheme.size()) : std::string_view();
}

}  // namespace

void expect_authorized(const Request& request, const AccessRules& rules) {
    const Scope scope = is_reading(request) ? Scope::read : Scope::write;
    if (is_open_to_all(request, rules) || (scope == Scope::read && !rules.is_private)) return;
    // A server without a writer listens on loopback only, and there everybody may write.
    if (!rules.is_private && !rules.is_beyond_loopback && !rules.tokens.has_writer()) return;
    if (const std::string_view token = token_of(request); !token.empty()) {
        if (rules.tokens.permit(token, scope)) return;
        if (rules.tokens.permit(token, Scope::read)) throw HttpProblem(403, "this token may read, not write");
    }
    throw HttpProblem(401,
                      std::string(scope == Scope::read ? "reading" : "writing") +
                          " needs the header field Authorization: Bearer <token>",
                      {{"WWW-Authenticate", "Bearer realm=\"anyrate\""}});
}

}  // namespace anyrate
