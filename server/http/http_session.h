#pragma once
#include "server/http/context.h"
#include "server/http/network_thread.h"

namespace anyrate {

/// Serves one connection until it ends: one request after the other, a body streamed to a file where the route takes
/// one, the handler on a pool, then the response; a live or events request takes the connection over. Never throws: a
/// request that cannot be read gets its problem document, a connection that breaks is dropped.
/// @param thread  the socket's  @param tls  nullptr for plain TCP
awaitable<void> serve_connection(tcp::socket socket, NetworkThread& thread, asio::ssl::context* tls,
                                 ServerContext& context);

}  // namespace anyrate
