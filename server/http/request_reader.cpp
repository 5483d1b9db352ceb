#include "server/http/request_reader.h"

#include <boost/asio/redirect_error.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/string.hpp>
#include <boost/beast/http/read.hpp>
#include <string>
#include <utility>
#include <vector>

#include "server/http/on_pool.h"
#include "server/http/problem.h"
#include "server/http/target.h"

namespace anyrate {
namespace {

namespace http = beast::http;

HttpProblem reading_problem(const HttpConnection& connection, const ErrorCode& error) {
    if (connection.stream->has_expired()) {
        ++connection.context.metrics.timeouts;
        return {408, "the request did not arrive in time"};
    }
    if (error == http::error::header_limit) return {431, "the request's header is longer than the server takes"};
    if (error == http::error::body_limit) return {413, "the request's body is longer than the server takes"};
    return {400, "this is no HTTP request: " + error.message()};
}

bool is_end_of_connection(const ErrorCode& error) {
    return error == http::error::end_of_stream || error == http::error::partial_message ||
           error == asio::error::connection_reset || error == asio::error::operation_aborted ||
           error == asio::error::eof || error == asio::error::broken_pipe;
}

/// What a proxy in front might read in another way than this server does: one that smuggles requests lives on that.
void expect_unambiguous(const http::request<http::buffer_body>& message) {
    const auto n_hosts = message.count(http::field::host);
    if (n_hosts > 1 || (n_hosts == 0 && message.version() >= 11))
        throw HttpProblem(400, "the request has " + std::to_string(n_hosts) + " Host fields; expected one");
    const auto codings = message.count(http::field::transfer_encoding);
    const auto coding = message[http::field::transfer_encoding];
    if (codings > 1 || (codings == 1 && !beast::iequals({coding.data(), coding.size()}, "chunked")))
        throw HttpProblem(501, "Transfer-Encoding \"" + std::string(coding) + "\": expected chunked or none");
}

awaitable<void> continue_if_expected(HttpConnection& connection, const Request& request) {
    if (request.headers.find("Expect").value_or("") != "100-continue") co_return;
    constexpr std::string_view go_on = "HTTP/1.1 100 Continue\r\n\r\n";
    co_await asio::async_write(*connection.stream, asio::buffer(go_on.data(), go_on.size()), use_awaitable);
}

}  // namespace

awaitable<bool> read_header(HttpConnection& connection, RequestParser& parser) {
    const HttpLimits& limits = connection.context.limits;
    parser.header_limit(static_cast<std::uint32_t>(limits.max_header_bytes));
    parser.body_limit(limits.max_upload_bytes);
    connection.stream->expires_after(limits.header_patience);
    ErrorCode error;
    connection.is_idle = true;
    co_await http::async_read_header(*connection.stream, connection.buffer, parser,
                                     asio::redirect_error(use_awaitable, error));
    connection.is_idle = false;
    if (!error) {
        expect_unambiguous(parser.get());
        co_return true;
    }
    const bool said_nothing = connection.buffer.size() == 0 && !parser.got_some();
    const bool is_late = connection.stream->has_expired();
    if (is_late ? said_nothing : is_end_of_connection(error)) co_return false;
    throw reading_problem(connection, error);
}

Request to_request(const RequestParser& parser) {
    const auto& message = parser.get();
    Request request;
    request.method = std::string(message.method_string());
    Target target = parse_target({message.target().data(), message.target().size()});
    request.path = std::move(target.path);
    request.query = std::move(target.query);
    for (const auto& field : message) request.headers.add(std::string(field.name_string()), std::string(field.value()));
    return request;
}

awaitable<void> read_body(HttpConnection& connection, RequestParser& parser, std::uint64_t max_bytes,
                          std::function<void(std::string_view)> take) {
    std::vector<char> piece(64 * 1024);
    std::uint64_t n_bytes = 0;
    while (!parser.is_done()) {
        parser.get().body() = {.data = piece.data(), .size = piece.size(), .more = true};
        connection.stream->expires_after(connection.context.limits.body_patience);
        ErrorCode error;
        co_await http::async_read(*connection.stream, connection.buffer, parser,
                                  asio::redirect_error(use_awaitable, error));
        if (error && error != http::error::need_buffer) throw reading_problem(connection, error);
        const std::size_t got = piece.size() - parser.get().body().size;
        n_bytes += got;
        connection.context.metrics.received_bytes += got;
        if (n_bytes > max_bytes) throw reading_problem(connection, http::error::body_limit);
        take(std::string_view(piece.data(), got));
    }
}

awaitable<std::uint64_t> receive_upload(HttpConnection& connection, RequestParser& parser, const Request& request,
                                        const std::filesystem::path& path) {
    co_await continue_if_expected(connection, request);
    const FileHandle file = create_file(path);
    std::uint64_t n_bytes = 0;
    co_await read_body(connection, parser, connection.context.limits.max_upload_bytes, [&](std::string_view piece) {
        write_all(file, as_bytes(piece));
        n_bytes += piece.size();
    });
    co_await on_pool(connection.context.upload_pool, [&] {
        sync_file(file);
        return true;
    });
    co_return n_bytes;
}

}  // namespace anyrate
