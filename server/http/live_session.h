#pragma once
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <memory>

#include "server/http/context.h"
#include "server/http/stream.h"
#include "server/http/wake_up.h"

namespace anyrate {

/// Turns a connection into a WebSocket and sends a model's frames as they are made.
///
/// Text messages are JSON: first {"type":"hello"}, last {"type":"end","state","error"?}. Binary messages are the bytes
/// of the log's live form, whole frames, coalesced to about 16 KB when the client is behind. They lie in memory once
/// for all clients (LiveFeed), so a slow client costs what the kernel has taken for it, 256 KB at most, and one that
/// takes next to nothing for the write patience is dropped. The client may send {"vertices": N} to raise its budget and
/// {"pause": true|false}.
/// Closes with 1000 when all is sent, 1001 when the server stops, 1011 when its storage does not answer (come again
/// with `from`).
awaitable<void> serve_live(std::shared_ptr<Stream> stream, beast::http::request<beast::http::empty_body> upgrade,
                           ServerContext& context, LiveBody wish, std::shared_ptr<WakeUp> wake_up);

}  // namespace anyrate
