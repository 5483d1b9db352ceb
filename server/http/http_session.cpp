#include "server/http/http_session.h"

#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "server/http/bearer.h"
#include "server/http/events_session.h"
#include "server/http/live_session.h"
#include "server/http/on_pool.h"
#include "server/http/problem.h"
#include "server/http/response_writer.h"
#include "server/http/target.h"
#include "server/http/wake_up.h"
#include "server/store/model_id.h"

namespace anyrate {
namespace {

namespace http = beast::http;
using Parser = http::request_parser<http::buffer_body>;

/// One connection between two requests and while one is served. Lives on one strand.
struct Connection {
    Connection(tcp::socket socket, ServerContext& server)
        : stream(std::move(socket)), context(server), wake_up(WakeUp::make(stream.get_executor())) {}

    TcpStream stream;
    ServerContext& context;
    beast::flat_buffer buffer;
    std::shared_ptr<WakeUp> wake_up;  ///< raised when the server drains
    bool is_idle = false;             ///< waits for a request
    bool must_close = false;          ///< after this response
};

/// Removes the file of an upload that nobody took.
class UploadFile {
public:
    explicit UploadFile(std::filesystem::path path) : path_(std::move(path)) {}
    ~UploadFile() {
        std::error_code ignored;  // it was moved, or the next start removes it
        std::filesystem::remove(path_, ignored);
    }
    UploadFile(const UploadFile&) = delete;
    UploadFile& operator=(const UploadFile&) = delete;
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

HttpProblem reading_problem(const ErrorCode& error) {
    if (error == http::error::header_limit) return {431, "the request's header is longer than the server takes"};
    if (error == http::error::body_limit) return {413, "the request's body is longer than the server takes"};
    if (error == beast::error::timeout) return {408, "the request did not arrive in time"};
    return {400, "this is no HTTP request: " + error.message()};
}

bool is_end_of_connection(const ErrorCode& error) {
    return error == http::error::end_of_stream || error == http::error::partial_message ||
           error == asio::error::connection_reset || error == asio::error::operation_aborted ||
           error == asio::error::eof || error == asio::error::broken_pipe;
}

/// Reads a header. @return false if the connection ended before there was one @throws HttpProblem
awaitable<bool> read_header(Connection& connection, Parser& parser) {
    const HttpLimits& limits = connection.context.limits;
    parser.header_limit(static_cast<std::uint32_t>(limits.max_header_bytes));
    parser.body_limit(limits.max_upload_bytes);
    connection.stream.expires_after(limits.header_patience);
    ErrorCode error;
    connection.is_idle = true;
    co_await http::async_read_header(connection.stream, connection.buffer, parser,
                                     asio::redirect_error(use_awaitable, error));
    connection.is_idle = false;
    if (!error) co_return true;
    const bool said_nothing = connection.buffer.size() == 0 && !parser.got_some();
    if (is_end_of_connection(error) || (said_nothing && error == beast::error::timeout)) co_return false;
    throw reading_problem(error);
}

Request to_request(const http::request<http::buffer_body>& message) {
    Request request;
    request.method = std::string(message.method_string());
    Target target = parse_target({message.target().data(), message.target().size()});
    request.path = std::move(target.path);
    request.query = std::move(target.query);
    for (const auto& field : message) request.headers.add(std::string(field.name_string()), std::string(field.value()));
    return request;
}

/// Reads the rest of the body, piece by piece. @param take gets each piece @throws HttpProblem
template <class Take>
awaitable<void> read_body(Connection& connection, Parser& parser, std::uint64_t max_bytes, const Take& take) {
    std::vector<char> piece(64 * 1024);
    std::uint64_t n_bytes = 0;
    while (!parser.is_done()) {
        parser.get().body() = {.data = piece.data(), .size = piece.size(), .more = true};
        connection.stream.expires_after(connection.context.limits.body_patience);
        ErrorCode error;
        co_await http::async_read(connection.stream, connection.buffer, parser,
                                  asio::redirect_error(use_awaitable, error));
        if (error && error != http::error::need_buffer) throw reading_problem(error);
        const std::size_t got = piece.size() - parser.get().body().size;
        n_bytes += got;
        if (n_bytes > max_bytes) throw reading_problem(http::error::body_limit);
        take(std::string_view(piece.data(), got));
    }
}

awaitable<void> continue_if_expected(Connection& connection, const Request& request) {
    if (request.headers.find("Expect").value_or("") != "100-continue") co_return;
    constexpr std::string_view go_on = "HTTP/1.1 100 Continue\r\n\r\n";
    co_await asio::async_write(connection.stream, asio::buffer(go_on.data(), go_on.size()), use_awaitable);
}

awaitable<std::uint64_t> receive_upload(Connection& connection, Parser& parser, const Request& request,
                                        const std::filesystem::path& path) {
    co_await continue_if_expected(connection, request);
    const FileHandle file = create_file(path);
    std::uint64_t n_bytes = 0;
    co_await read_body(connection, parser, connection.context.limits.max_upload_bytes, [&](std::string_view piece) {
        write_all(file, as_bytes(piece));
        n_bytes += piece.size();
    });
    co_await on_pool(connection.context.quick_pool, [&] {
        sync_file(file);
        return true;
    });
    co_return n_bytes;
}

/// Everything about a request that is known before its body: where it goes, whether it may.
const Route& admit(ServerContext& context, Request& request) {
    const Route& route = context.router.find(request);
    expect_authorized(request, context.token);
    return route;
}

awaitable<Response> handle(Connection& connection, Parser& parser, Request& request) {
    ServerContext& context = connection.context;
    const Route& route = admit(context, request);
    asio::thread_pool& pool = route.is_heavy ? context.heavy_pool : context.quick_pool;
    if (!route.takes_upload) {
        co_await read_body(connection, parser, context.limits.max_small_body_bytes, [](std::string_view) {});
        co_return co_await on_pool(pool, [&] { return route.handle(request); });
    }
    co_await on_pool(pool, [&] {
        if (route.check) route.check(request);
        return true;
    });
    const UploadFile upload(context.service.store.upload_file(new_model_id()));
    const std::uint64_t n_bytes = co_await receive_upload(connection, parser, request, upload.path());
    request.upload = Upload{upload.path(), n_bytes};
    co_return co_await on_pool(pool, [&] { return route.handle(request); });
}

/// The handler's answer, or the problem document of what went wrong. If the body was not read to its end the connection
/// cannot be used again.
awaitable<Response> handle_or_explain(Connection& connection, Parser& parser, Request& request) {
    std::exception_ptr failure;
    try {
        co_return co_await handle(connection, parser, request);
    } catch (const boost::system::system_error&) {
        throw;  // the connection itself
    } catch (...) {
        failure = std::current_exception();
    }
    const HttpProblem problem = to_problem(failure);
    if (problem.status >= 500) {
        try {
            std::rethrow_exception(failure);
        } catch (const std::exception& error) {
            connection.context.log(request.method + " " + request.path + ": " + error.what());
        }
    }
    connection.must_close = connection.must_close || !parser.is_done();
    co_return problem_response(problem);
}

awaitable<void> write(Connection& connection, const Response& response, bool head_only) {
    co_await write_response(connection.stream, response,
                            {.head_only = head_only,
                             .keep_alive = !connection.must_close,
                             .patience = connection.context.limits.write_patience});
}

/// Lets a client that is still sending read the answer before the connection goes: closing at once would reset it.
awaitable<void> linger(Connection& connection) {
    ErrorCode error;
    connection.stream.socket().shutdown(tcp::socket::shutdown_send, error);
    std::vector<char> ignored(64 * 1024);
    connection.stream.expires_after(std::chrono::seconds(5));
    while (!error)
        co_await connection.stream.async_read_some(asio::buffer(ignored), asio::redirect_error(use_awaitable, error));
}

Response upgrade_required() {
    return problem_response(
        {426, "the live stream is a WebSocket: send Upgrade: websocket", {{"Upgrade", "websocket"}}});
}

/// Serves one request. @return whether the connection can take another
awaitable<bool> serve_request(Connection& connection) {
    Parser parser;
    const bool arrived = co_await read_header(connection, parser);
    if (!arrived) co_return false;
    connection.must_close = !parser.get().keep_alive() || connection.context.sessions.is_draining();
    Request request = to_request(parser.get());
    Response response = co_await handle_or_explain(connection, parser, request);

    if (auto* live = std::get_if<LiveBody>(&response.body)) {
        if (beast::websocket::is_upgrade(parser.get())) {
            http::request<http::empty_body> upgrade{http::request_header<>(parser.get().base())};
            co_await serve_live(std::move(connection.stream), std::move(upgrade), connection.context, std::move(*live),
                                connection.wake_up);
            co_return false;
        }
        response = upgrade_required();
    }
    if (std::holds_alternative<EventsBody>(response.body)) {
        if (request.method == "HEAD")
            co_await write_open_header(connection.stream, response, connection.context.limits.write_patience);
        else
            co_await serve_events(connection.stream, connection.context, response, connection.wake_up);
        co_return false;
    }
    connection.must_close = connection.must_close || connection.context.sessions.is_draining();
    co_await write(connection, response, request.method == "HEAD");
    co_return !connection.must_close;
}

awaitable<void> serve_requests(Connection& connection) {
    std::optional<HttpProblem> problem;
    try {
        while (co_await serve_request(connection)) {
        }
    } catch (const HttpProblem& unreadable) {
        problem = unreadable;
    }
    if (problem) {
        connection.must_close = true;
        co_await write(connection, problem_response(*problem), false);
    }
    if (connection.stream.socket().is_open()) co_await linger(connection);
}

}  // namespace

awaitable<void> serve_connection(tcp::socket socket, ServerContext& context) {
    const auto connection = std::make_shared<Connection>(std::move(socket), context);
    const auto on_drain = [connection] {
        asio::post(connection->stream.get_executor(), [connection] {
            connection->wake_up->raise();
            if (connection->is_idle) connection->stream.cancel();
        });
    };
    const Sessions::Membership membership(context.sessions, on_drain);
    try {
        co_await serve_requests(*connection);
    } catch (const boost::system::system_error&) {
        // The connection broke, which is its peer's business; the socket closes with this scope.
    } catch (const std::exception& error) {
        context.log(std::string("connection: ") + error.what());
    }
}

}  // namespace anyrate
