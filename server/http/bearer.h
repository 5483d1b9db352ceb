#pragma once
#include "server/http/message.h"
#include "server/http/tokens.h"

namespace anyrate {

/// Who needs a token: writers, once there is one for them; readers too if the server is private.
struct AccessRules {
    Tokens& tokens;
    bool is_private = false;
    bool is_beyond_loopback = false;  ///< then nobody may write once the last token is revoked
    bool has_viewer = false;          ///< its files are open to all, also on a private server
};

/// Lets a request pass or throws. Tokens are taken from the field Authorization (Bearer) only, for addresses end in
/// logs; of a WebSocket also from a protocol "anyrate.bearer.<token>" that it offers, for a browser can send no other
/// field with it. GET and HEAD read, everything else writes; /healthz, /readyz and the viewer are open to all.
/// @throws HttpProblem 401 no token, or an unknown one; 403 it may read but not write
void expect_authorized(const Request& request, const AccessRules& rules);

}  // namespace anyrate
