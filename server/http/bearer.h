#pragma once
#include <string_view>

#include "server/http/message.h"

namespace anyrate {

/// Refuses a request that writes without the server's token. Reading is open, and so is everything if `token` is empty
/// (such a server listens on loopback only). The comparison takes as long for a wrong token as for the right one.
/// @throws HttpProblem 401 with WWW-Authenticate
void expect_authorized(const Request& request, std::string_view token);

}  // namespace anyrate
