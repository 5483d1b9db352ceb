#pragma once
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <memory>

#include "server/http/context.h"
#include "server/http/wake_up.h"

namespace anyrate {

/// Turns a connection into a WebSocket and sends a model's frames as they are made.
///
/// Text messages are JSON: first {"type":"hello"}, last {"type":"end","state","error"?}. Binary messages are the bytes
/// of the log's live form, whole frames, coalesced to about 16 KB. The log on the disk is the queue: a slow client
/// costs one message of memory, and one that takes nothing for the write patience is dropped. The client may send
/// {"vertices": N} to raise its budget and {"pause": true|false}.
/// Closes with 1000 when all is sent, 1001 when the server stops, 1012 when the log was begun anew (start at 0 again).
awaitable<void> serve_live(TcpStream stream, beast::http::request<beast::http::empty_body> upgrade,
                           ServerContext& context, LiveBody wish, std::shared_ptr<WakeUp> wake_up);

}  // namespace anyrate
