#pragma once
#include <chrono>

#include "server/http/message.h"
#include "server/http/net.h"

namespace anyrate {

struct WriteOptions {
    bool head_only = false;  ///< the request was HEAD
    bool keep_alive = true;
    std::chrono::seconds patience{30};  ///< for a reader that takes nothing
};

/// Sends a response whose body is text or bytes of a file; the file's go from the page cache to the socket without
/// being copied through the program. @throws boost::system::system_error the connection broke or the reader was too
/// slow
awaitable<void> write_response(TcpStream& stream, const Response& response, const WriteOptions& options);

/// Sends only the header of a response whose body has no length yet; it ends with the connection.
awaitable<void> write_open_header(TcpStream& stream, const Response& response, std::chrono::seconds patience);

}  // namespace anyrate
