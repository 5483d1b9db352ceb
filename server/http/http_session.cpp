#include "server/http/http_session.h"

#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/string.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "server/http/bearer.h"
#include "server/http/cors.h"
#include "server/http/events_session.h"
#include "server/http/file_response.h"
#include "server/http/hot_path.h"
#include "server/http/live_session.h"
#include "server/http/on_pool.h"
#include "server/http/problem.h"
#include "server/http/request_id.h"
#include "server/http/response_writer.h"
#include "server/http/target.h"
#include "server/http/wake_up.h"
#include "server/store/model_id.h"

namespace anyrate {
namespace {

namespace http = beast::http;
using Parser = http::request_parser<http::buffer_body>;

/// One connection between two requests and while one is served. Lives on one network thread.
struct Connection {
    Connection(tcp::socket socket, NetworkThread& thread, asio::ssl::context* tls, ServerContext& server)
        : client(client_of(socket)),
          stream(std::make_shared<Stream>(std::move(socket), thread.deadlines(), tls)),
          context(server),
          wake_up(WakeUp::make(stream->get_executor())) {}

    static std::string client_of(const tcp::socket& socket) {
        ErrorCode error;  // then it is gone already
        const auto endpoint = socket.remote_endpoint(error);
        return error ? "" : endpoint.address().to_string();
    }

    std::string client;  ///< its address
    std::shared_ptr<Stream> stream;
    ServerContext& context;
    beast::flat_buffer buffer;
    std::shared_ptr<WakeUp> wake_up;  ///< raised when the server drains
    bool is_idle = false;             ///< waits for a request
    bool must_close = false;          ///< after this response
};

/// What is told of a request when it is answered.
struct Account {
    explicit Account(Connection& connection) : connection_(connection) {}
    Account(const Account&) = delete;
    Account& operator=(const Account&) = delete;

    std::string request_id;
    std::size_t route = std::size_t(-1);  ///< number in the router
    std::string error;                    ///< for the operator only

    void close(const Request& request, const Response& response, std::uint64_t n_sent) {
        Metrics& metrics = connection_.context.metrics;
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begun_;
        RouteMetrics& counted = *metrics.routes[std::min(route, metrics.routes.size() - 1)];
        const auto digit = static_cast<std::size_t>(response.status / 100);
        counted.by_class[std::min(digit, counted.by_class.size() - 1)].fetch_add(1, std::memory_order_relaxed);
        counted.seconds.observe(elapsed.count());
        metrics.sent_bytes.fetch_add(n_sent, std::memory_order_relaxed);
        if (!connection_.context.log_access || response.status < connection_.context.log_from_status) return;
        connection_.context.log_access({.request_id = request_id,
                                        .client = connection_.client,
                                        .method = request.method,
                                        .path = request.path,
                                        .status = response.status,
                                        .n_bytes = n_sent,
                                        .seconds = elapsed.count(),
                                        .error = error});
    }

private:
    Connection& connection_;
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
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

HttpProblem reading_problem(const Connection& connection, const ErrorCode& error) {
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

/// Reads a header. @return false if the connection ended before there was one @throws HttpProblem
awaitable<bool> read_header(Connection& connection, Parser& parser) {
    const HttpLimits& limits = connection.context.limits;
    parser.header_limit(static_cast<std::uint32_t>(limits.max_header_bytes));
    parser.body_limit(limits.max_upload_bytes);
    connection.stream->expires_after(limits.header_patience);
    ErrorCode error;
    connection.is_idle = true;
    co_await http::async_read_header(*connection.stream, connection.buffer, parser,
                                     asio::redirect_error(use_awaitable, error));
    connection.is_idle = false;
    if (!error) co_return true;
    const bool said_nothing = connection.buffer.size() == 0 && !parser.got_some();
    const bool is_late = connection.stream->has_expired();
    if (is_late ? said_nothing : is_end_of_connection(error)) co_return false;
    throw reading_problem(connection, error);
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

awaitable<void> continue_if_expected(Connection& connection, const Request& request) {
    if (request.headers.find("Expect").value_or("") != "100-continue") co_return;
    constexpr std::string_view go_on = "HTTP/1.1 100 Continue\r\n\r\n";
    co_await asio::async_write(*connection.stream, asio::buffer(go_on.data(), go_on.size()), use_awaitable);
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
    co_await on_pool(connection.context.upload_pool, [&] {
        sync_file(file);
        return true;
    });
    co_return n_bytes;
}

/// Everything about a request that is known before its body: where it goes, whether it may.
const Route& admit(ServerContext& context, Request& request, Account& account) {
    const Route& route = context.router.find(request);
    account.route = context.router.number_of(route);
    try {
        expect_authorized(request, context.access);
    } catch (const HttpProblem&) {
        ++context.metrics.rejected_tokens;
        throw;
    }
    return route;
}

awaitable<Response> handle(Connection& connection, Parser& parser, Request& request, Account& account) {
    ServerContext& context = connection.context;
    if (auto preflight = answer_preflight(request, context.cors_origins)) co_return std::move(*preflight);
    const Route& route = admit(context, request, account);
    asio::thread_pool& pool = route.takes_upload ? context.upload_pool
                              : route.is_heavy   ? context.heavy_pool
                                                 : context.quick_pool;
    if (!route.takes_upload) {
        if (!parser.is_done())
            co_await read_body(connection, parser, context.limits.max_small_body_bytes, [](std::string_view) {});
        if (route.answer_at_once)
            if (auto response = route.answer_at_once(request)) co_return std::move(*response);
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
awaitable<Response> handle_or_explain(Connection& connection, Parser& parser, Request& request, Account& account) {
    std::exception_ptr failure;
    try {
        co_return co_await handle(connection, parser, request, account);
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
            account.error = error.what();
            connection.context.log(account.request_id + " " + request.method + " " + request.path + ": " +
                                   error.what());
        }
    }
    connection.must_close = connection.must_close || !parser.is_done();
    co_return problem_response(problem);
}

awaitable<void> write(Connection& connection, const Response& response, bool head_only) {
    co_await write_response(*connection.stream, response,
                            {.head_only = head_only,
                             .keep_alive = !connection.must_close,
                             .patience = connection.context.limits.write_patience});
}

/// Lets a client that is still sending read the answer before the connection goes: closing at once would reset it.
awaitable<void> linger(Connection& connection) {
    Stream& stream = *connection.stream;
    stream.expires_after(std::chrono::seconds(5));
    co_await stream.send_end();
    std::vector<char> ignored(64 * 1024);
    ErrorCode error;
    while (!error)
        co_await stream.socket().async_read_some(asio::buffer(ignored), asio::redirect_error(use_awaitable, error));
}

Response upgrade_required() {
    return problem_response(
        {426, "the live stream is a WebSocket: send Upgrade: websocket", {{"Upgrade", "websocket"}}});
}

/// The answer goes on as a WebSocket. @return a response if the client did not ask for one
awaitable<std::optional<Response>> go_on_live(Connection& connection, Parser& parser, LiveBody live) {
    if (!beast::websocket::is_upgrade(parser.get())) co_return upgrade_required();
    http::request<http::empty_body> upgrade{http::request_header<>(parser.get().base())};
    connection.buffer.clear();  // there may be thousands of such connections, idle for hours
    connection.buffer.shrink_to_fit();
    co_await serve_live(connection.stream, std::move(upgrade), connection.context, std::move(live), connection.wake_up);
    co_return std::nullopt;
}

awaitable<void> go_on_with_events(Connection& connection, const Request& request, const Response& response) {
    if (request.method == "HEAD")
        co_await write_open_header(*connection.stream, response, connection.context.limits.write_patience);
    else
        co_await serve_events(*connection.stream, connection.context, response, connection.wake_up);
}

/// Serves one request. @return whether the connection can take another
awaitable<bool> serve_request(Connection& connection) {
    Parser parser;
    const bool arrived = co_await read_header(connection, parser);
    if (!arrived) co_return false;
    expect_unambiguous(parser.get());
    connection.must_close = !parser.get().keep_alive() || connection.context.sessions.is_draining();
    Account account(connection);
    Request request = to_request(parser.get());
    account.request_id = request_id_of(request);
    const auto sign = [&](Response& answer) {
        answer.headers.add("X-Request-Id", account.request_id);
        allow_origin(answer, request, connection.context.cors_origins);
        if (connection.context.access.is_private) keep_from_shared_caches(answer);
    };
    Response response = co_await handle_or_explain(connection, parser, request, account);
    sign(response);

    if (auto* live = std::get_if<LiveBody>(&response.body)) {
        auto refusal = co_await go_on_live(connection, parser, std::move(*live));
        if (!refusal) {
            account.close(request, response, 0);
            co_return false;
        }
        response = std::move(*refusal);
        sign(response);
    }
    if (std::holds_alternative<EventsBody>(response.body)) {
        co_await go_on_with_events(connection, request, response);
        account.close(request, response, 0);
        co_return false;
    }
    connection.must_close = connection.must_close || connection.context.sessions.is_draining();
    const bool is_head = request.method == "HEAD";
    co_await write(connection, response, is_head);
    account.close(request, response, is_head ? 0 : body_bytes(response));
    co_return !connection.must_close;
}

/// Whether the hot path answers as the general one would: nothing asks for more than it does.
bool may_serve_hot(const Connection& connection) {
    const ServerContext& context = connection.context;
    const bool is_logged = context.log_access && context.log_from_status <= 206;
    return !connection.stream->is_tls() && !context.access.is_private && context.cors_origins.empty() && !is_logged;
}

std::string_view received(const Connection& connection) {
    return {static_cast<const char*>(connection.buffer.data().data()), connection.buffer.size()};
}

void count_hot(Metrics& metrics, RouteMetrics& counted, std::uint64_t n_bytes,
               std::chrono::steady_clock::time_point begun) {
    counted.by_class[2].fetch_add(1, std::memory_order_relaxed);
    counted.seconds.observe(std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
    metrics.sent_bytes.fetch_add(n_bytes, std::memory_order_relaxed);
}

/// Serves requests for logs in memory until another one comes, whose bytes stay in the buffer.
/// @return false if the connection ended
awaitable<bool> serve_hot(Connection& connection) {
    ServerContext& context = connection.context;
    RouteMetrics& counted = *context.metrics.routes[context.hot_route];
    std::string header;
    for (;;) {
        if (connection.buffer.size() > 0) {
            if (context.sessions.is_draining()) co_return true;
            const auto answer = answer_hot(received(connection), context.service.hot_logs, header);
            if (!answer) co_return true;
            connection.buffer.consume(answer->n_request_bytes);
            // Most answers go at once; no coroutine is made for those.
            const auto begun = std::chrono::steady_clock::now();
            std::size_t n_sent = 0;
            if (!write_now(*connection.stream, header, answer->body, n_sent))
                co_await write_rest(*connection.stream, header, answer->body, n_sent, context.limits.write_patience);
            count_hot(context.metrics, counted, answer->body.n_bytes, begun);
            continue;
        }
        connection.stream->expires_after(context.limits.header_patience);
        connection.is_idle = true;
        ErrorCode error;
        const std::size_t n = co_await connection.stream->async_read_some(connection.buffer.prepare(4096),
                                                                          asio::redirect_error(use_awaitable, error));
        connection.is_idle = false;
        if (error) co_return false;
        connection.buffer.commit(n);
    }
}

awaitable<void> serve_requests(Connection& connection) {
    std::optional<HttpProblem> problem;
    const bool is_hot = may_serve_hot(connection);
    try {
        for (bool goes_on = true; goes_on;) {
            if (is_hot && !co_await serve_hot(connection)) break;
            goes_on = co_await serve_request(connection);
        }
    } catch (const HttpProblem& unreadable) {
        problem = unreadable;
    }
    if (problem) {
        connection.must_close = true;
        Response response = problem_response(*problem);
        response.headers.add("X-Request-Id", fresh_request_id());
        co_await write(connection, response, false);
    }
    if (connection.stream->socket().is_open()) co_await linger(connection);
}

}  // namespace

awaitable<void> serve_connection(tcp::socket socket, NetworkThread& thread, asio::ssl::context* tls,
                                 ServerContext& context) {
    const auto connection = std::make_shared<Connection>(std::move(socket), thread, tls, context);
    const auto on_drain = [connection] {
        asio::post(connection->stream->get_executor(), [connection] {
            connection->wake_up->raise();
            if (connection->is_idle) connection->stream->cancel();
        });
    };
    const Counted counted(context.metrics.connections);
    const Sessions::Membership membership(context.sessions, on_drain);
    try {
        connection->stream->socket().native_non_blocking(true);
        connection->stream->expires_after(context.limits.header_patience);
        co_await connection->stream->handshake();
        co_await serve_requests(*connection);
    } catch (const boost::system::system_error&) {
        // The connection broke, which is its peer's business; the socket closes with this scope.
    } catch (const std::exception& error) {
        context.log(std::string("connection: ") + error.what());
    }
}

}  // namespace anyrate
