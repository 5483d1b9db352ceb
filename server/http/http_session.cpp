#include "server/http/http_session.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
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
#include "server/http/hot_session.h"
#include "server/http/http_connection.h"
#include "server/http/live_session.h"
#include "server/http/on_pool.h"
#include "server/http/problem.h"
#include "server/http/request_id.h"
#include "server/http/request_reader.h"
#include "server/http/response_writer.h"
#include "server/store/model_id.h"

namespace anyrate {
namespace {

namespace http = beast::http;

/// What is told of a request when it is answered.
struct Account {
    explicit Account(HttpConnection& connection) : connection_(connection) {}
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
    HttpConnection& connection_;
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

awaitable<Response> handle(HttpConnection& connection, RequestParser& parser, Request& request, Account& account) {
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
awaitable<Response> handle_or_explain(HttpConnection& connection, RequestParser& parser, Request& request,
                                      Account& account) {
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

awaitable<void> write(HttpConnection& connection, const Response& response, bool head_only) {
    co_await write_response(*connection.stream, response,
                            {.head_only = head_only,
                             .keep_alive = !connection.must_close,
                             .patience = connection.context.limits.write_patience});
}

/// Lets a client that is still sending read the answer before the connection goes: closing at once would reset it.
awaitable<void> linger(HttpConnection& connection) {
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
awaitable<std::optional<Response>> go_on_live(HttpConnection& connection, RequestParser& parser, LiveBody live) {
    if (!beast::websocket::is_upgrade(parser.get())) co_return upgrade_required();
    http::request<http::empty_body> upgrade{http::request_header<>(parser.get().base())};
    connection.buffer.clear();  // there may be thousands of such connections, idle for hours
    connection.buffer.shrink_to_fit();
    co_await serve_live(connection.stream, std::move(upgrade), connection.context, std::move(live), connection.wake_up);
    co_return std::nullopt;
}

awaitable<void> go_on_with_events(HttpConnection& connection, const Request& request, const Response& response) {
    if (request.method == "HEAD")
        co_await write_open_header(*connection.stream, response, connection.context.limits.write_patience);
    else
        co_await serve_events(*connection.stream, connection.context, response, connection.wake_up);
}

/// Serves one request. @return whether the connection can take another
awaitable<bool> serve_request(HttpConnection& connection) {
    RequestParser parser;
    const bool arrived = co_await read_header(connection, parser);
    if (!arrived) co_return false;
    connection.must_close = !parser.get().keep_alive() || connection.context.sessions.is_draining();
    Account account(connection);
    Request request = to_request(parser);
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

awaitable<void> serve_requests(HttpConnection& connection) {
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
    const auto connection = std::make_shared<HttpConnection>(std::move(socket), thread, tls, context);
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
