#include "server/http/cors.h"

#include <algorithm>

namespace anyrate {
namespace {

bool is_any_origin(const std::vector<std::string>& origins) {
    return std::find(origins.begin(), origins.end(), "*") != origins.end();
}

/// What Access-Control-Allow-Origin says to a request; nullopt if its origin is not allowed.
std::optional<std::string> allowed_origin(const Request& request, const std::vector<std::string>& origins) {
    const auto origin = request.headers.find("Origin");
    if (!origin || origins.empty()) return std::nullopt;
    if (is_any_origin(origins)) return "*";
    if (std::find(origins.begin(), origins.end(), *origin) != origins.end()) return std::string(*origin);
    return std::nullopt;
}

}  // namespace

std::optional<Response> answer_preflight(const Request& request, const std::vector<std::string>& origins) {
    if (request.method != "OPTIONS" || !request.headers.find("Access-Control-Request-Method")) return std::nullopt;
    if (!allowed_origin(request, origins)) return std::nullopt;
    return Response{.status = 204,
                    .headers = {{"Access-Control-Allow-Methods", "GET, HEAD, POST, PUT, DELETE"},
                                {"Access-Control-Allow-Headers",
                                 "Authorization, Content-Type, Content-Digest, Digest, Idempotency-Key, If-Match, "
                                 "If-None-Match, If-Range, Range, X-Request-Id"},
                                {"Access-Control-Max-Age", "86400"}},
                    .body = {}};
}

void allow_origin(Response& response, const Request& request, const std::vector<std::string>& origins) {
    if (origins.empty()) return;
    // A cache may give what was asked for without an origin to a page that needs the field: so any answer is marked.
    const bool is_any = is_any_origin(origins);
    if (!is_any) response.headers.add("Vary", "Origin");
    const auto origin = is_any ? std::optional<std::string>("*") : allowed_origin(request, origins);
    if (!origin) return;
    response.headers.add("Access-Control-Allow-Origin", *origin);
    response.headers.add("Access-Control-Expose-Headers",
                         "Accept-Ranges, Content-Range, ETag, Location, Retry-After, X-Request-Id");
}

}  // namespace anyrate
