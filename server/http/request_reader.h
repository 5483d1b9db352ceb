#pragma once
// Requests as they come over a connection: each wait has its deadline, each part its limit.
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "server/http/http_connection.h"
#include "server/http/message.h"
#include "server/http/net.h"

namespace anyrate {

/// Leaves the body to read_body().
using RequestParser = beast::http::request_parser<beast::http::buffer_body>;

/// Reads a header. @return false if the connection ended before there was one @throws HttpProblem it is none, is too
/// long, came too late, or might be read in two ways
awaitable<bool> read_header(HttpConnection& connection, RequestParser& parser);

/// The request of a header. @throws HttpProblem
Request to_request(const RequestParser& parser);

/// Reads the rest of the body, piece by piece. @param take  gets each piece @throws HttpProblem
awaitable<void> read_body(HttpConnection& connection, RequestParser& parser, std::uint64_t max_bytes,
                          std::function<void(std::string_view)> take);

/// Reads the body into a new file, which is on the disk then. @return its bytes @throws HttpProblem, IoError
awaitable<std::uint64_t> receive_upload(HttpConnection& connection, RequestParser& parser, const Request& request,
                                        const std::filesystem::path& path);

}  // namespace anyrate
