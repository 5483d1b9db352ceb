#pragma once
#include <chrono>
#include <cstdint>
#include <string_view>

#include "server/http/message.h"
#include "server/http/net.h"
#include "server/http/stream.h"

namespace anyrate {

struct WriteOptions {
    bool head_only = false;  ///< the request was HEAD
    bool keep_alive = true;
    std::chrono::seconds patience{30};  ///< for a reader that takes nothing
};

/// Sends a response whose body is text or bytes of a file. Bytes in memory go with the header in one call; a file's go
/// from the page cache to the socket without being copied through the program (except under TLS).
/// @throws boost::system::system_error the connection broke or the reader was too slow
awaitable<void> write_response(Stream& stream, const Response& response, const WriteOptions& options);

/// Sends a header and a short body that is in memory over plain TCP, as far as that goes without a wait.
/// @param n_sent  gets the bytes that went @return whether all did @throws boost::system::system_error
bool write_now(Stream& stream, std::string_view header, const FileBody& body, std::size_t& n_sent);
/// Sends what write_now() left, or a longer body from its file.
awaitable<void> write_rest(Stream& stream, std::string_view header, const FileBody& body, std::size_t n_sent,
                           std::chrono::seconds patience);

/// Sends only the header of a response whose body has no length yet; it ends with the connection.
awaitable<void> write_open_header(Stream& stream, const Response& response, std::chrono::seconds patience);

/// Bytes of a response's body.
std::uint64_t body_bytes(const Response& response);

}  // namespace anyrate
