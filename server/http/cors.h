#pragma once
#include <optional>
#include <string>
#include <vector>

#include "server/http/message.h"

namespace anyrate {

// Cross-origin requests of browsers (Fetch standard, "CORS protocol"). The origins are those that the operator allows,
// as in "https://example.org"; "*" allows any. Cookies are never used, so no credentials are allowed.

/// The answer to a preflight (OPTIONS with Origin and Access-Control-Request-Method) of an allowed origin; nullopt for
/// every other request.
std::optional<Response> answer_preflight(const Request& request, const std::vector<std::string>& origins);

/// Lets a page of an allowed origin read the answer and the header fields that clients of logs need.
void allow_origin(Response& response, const Request& request, const std::vector<std::string>& origins);

}  // namespace anyrate
