#pragma once
#include "server/http/http_connection.h"
#include "server/http/net.h"

namespace anyrate {

/// Whether the hot path (hot_path.h) answers as the general one would: nothing asks for more than it does.
bool may_serve_hot(const HttpConnection& connection);

/// Serves requests for logs in memory until another one comes, whose bytes stay in the buffer.
/// @return false if the connection ended
awaitable<bool> serve_hot(HttpConnection& connection);

}  // namespace anyrate
