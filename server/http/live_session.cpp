#include "server/http/live_session.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "server/http/live_cursor.h"
#include "server/http/live_feed.h"
#include "server/http/live_message.h"

namespace anyrate {
namespace {

namespace websocket = beast::websocket;

/// What a client may offer beside a token (bearer.h): a browser wants one of its protocols chosen.
constexpr const char* live_protocol = "anyrate.live";

/// One upgraded connection. Its coroutines run on its network thread.
struct Connection {
    Connection(std::shared_ptr<Stream> upgraded, ServerContext& server, LiveBody asked, std::shared_ptr<WakeUp> news)
        : stream(std::move(upgraded)),
          socket(*stream),
          context(server),
          wish(std::move(asked)),
          wake_up(std::move(news)),
          cursor(wish.from, wish.max_vertices) {}

    std::shared_ptr<Stream> stream;
    websocket::stream<Stream&> socket;
    ServerContext& context;
    LiveBody wish;
    std::shared_ptr<WakeUp> wake_up;
    LiveCursor cursor;
    bool is_paused = false;
    bool is_gone = false;  ///< the client closed, or its connection broke
};

/// Closes the connection at the end of a scope, also by exception: the reading coroutine ends with it.
class CloseAtEnd {
public:
    explicit CloseAtEnd(Connection& connection) : connection_(connection) {}
    ~CloseAtEnd() { connection_.stream->close(); }
    CloseAtEnd(const CloseAtEnd&) = delete;
    CloseAtEnd& operator=(const CloseAtEnd&) = delete;

private:
    Connection& connection_;
};

bool offers_live_protocol(const beast::http::request<beast::http::empty_body>& upgrade) {
    return beast::http::token_list(upgrade[beast::http::field::sec_websocket_protocol]).exists(live_protocol);
}

void set_options(Connection& connection, bool names_protocol) {
    auto& socket = connection.socket;
    // The kernel doubles what it is told, for its own accounts.
    ErrorCode ignored;  // then the kernel's own limits hold
    connection.stream->socket().set_option(
        asio::socket_base::send_buffer_size(static_cast<int>(connection.context.limits.live_queue_bytes / 2)), ignored);
    socket.set_option(websocket::stream_base::timeout{.handshake_timeout = std::chrono::seconds(10),
                                                      .idle_timeout = std::chrono::seconds(120),
                                                      .keep_alive_pings = true});
    socket.set_option(websocket::stream_base::decorator([names_protocol](websocket::response_type& response) {
        response.set(beast::http::field::server, "anyrate");
        if (names_protocol) response.set(beast::http::field::sec_websocket_protocol, live_protocol);
    }));
    socket.read_message_max(4096);
    socket.auto_fragment(false);  // a message goes as it lies in memory, in one frame
}

/// @return false if the message is none that a client may send
bool apply_client_message(Connection& connection, const std::string& text) {
    const auto message = parse_live_message(text);
    if (!message) return false;
    if (message->max_vertices) connection.cursor.set_max_vertices(*message->max_vertices);
    if (message->pause) connection.is_paused = *message->pause;
    return true;
}

awaitable<void> read_client(std::shared_ptr<Connection> connection) {
    beast::flat_buffer buffer;
    ErrorCode error;
    while (!error) {
        co_await connection->socket.async_read(buffer, asio::redirect_error(use_awaitable, error));
        if (error) break;
        const bool understood = apply_client_message(*connection, beast::buffers_to_string(buffer.data()));
        buffer.consume(buffer.size());
        connection->wake_up->raise();
        if (!understood) break;
    }
    connection->is_gone = true;
    connection->wake_up->raise();
}

/// Sends one message; a client that takes next to nothing for the write patience loses its connection.
template <class Buffers>
awaitable<void> send(Connection& connection, const Buffers& message, bool is_text) {
    Metrics& metrics = connection.context.metrics;
    connection.stream->expires_without_progress(connection.context.limits.write_patience);
    connection.socket.text(is_text);
    ErrorCode error;
    const std::size_t n_bytes =
        co_await connection.socket.async_write(message, asio::redirect_error(use_awaitable, error));
    if (connection.stream->has_expired()) ++metrics.live_evictions;
    if (error) throw boost::system::system_error(error);
    connection.stream->expires_never();
    ++metrics.live_messages;
    metrics.live_bytes += n_bytes;
    metrics.sent_bytes += n_bytes;
}

awaitable<void> send_text(Connection& connection, std::string text) {
    co_await send(connection, asio::buffer(text), true);
}

awaitable<void> send_range(Connection& connection, const LogBytes& bytes, const LogRange& range) {
    std::vector<asio::const_buffer> parts;
    for (const auto part : bytes.slice(range.begin, range.end)) parts.emplace_back(part.data(), part.size());
    co_await send(connection, parts, false);
}

/// Sends what the client has not yet of this view. @return whether that was all there will ever be
awaitable<bool> send_frames(Connection& connection, const LiveView& view) {
    const LogView& log = *view.log;
    if (connection.cursor.log_id() != log.log_id) {
        std::string hello = connection.cursor.hello(log);
        co_await send_text(connection, std::move(hello));
    }
    while (!connection.is_gone && !connection.is_paused && !connection.context.sessions.is_draining()) {
        const auto range = connection.cursor.next_message(log, connection.context.limits.live_message_bytes);
        if (!range) break;
        co_await send_range(connection, *view.bytes, *range);
    }
    co_return !connection.is_paused && connection.cursor.is_complete(log);
}

std::string end_message(const std::optional<ModelRecord>& model) {
    nlohmann::ordered_json end = {{"type", "end"}, {"state", model ? state_name(model->state) : "deleted"}};
    if (model && !model->error.empty()) end["error"] = model->error;
    return end.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// Sends what a view has for this client. @return the reason to end, if there is one
awaitable<std::optional<websocket::close_code>> send_view(Connection& connection, const LiveView& view) {
    if (view.has_failed) co_return websocket::close_code::internal_error;
    const bool is_complete = view.log && co_await send_frames(connection, view);
    const bool is_over = !view.model || is_final(view.model->state);
    const bool is_sealed = view.log && view.log->complete;
    // A log is sealed a moment before the catalog hears of it: who is told the end finds it there, too.
    if (!(is_sealed ? is_complete && is_over : is_complete || is_over)) co_return std::nullopt;
    if (connection.is_gone || connection.context.sessions.is_draining()) co_return std::nullopt;
    std::string end = end_message(view.model);
    co_await send_text(connection, std::move(end));
    co_return websocket::close_code::normal;
}

/// Follows the model until there is a reason to end. @return the reason
awaitable<websocket::close_code> follow(Connection& connection) {
    LiveFeed::Client client(connection.context.live_feeds.of(connection.wish.model_id), connection.wake_up);
    for (;;) {
        if (connection.is_gone) co_return websocket::close_code::none;
        if (connection.context.sessions.is_draining()) co_return websocket::close_code::going_away;
        if (const auto view = client.view()) {
            const auto reason = co_await send_view(connection, *view);
            if (reason) co_return *reason;
        }
        const bool raised = co_await connection.wake_up->wait(std::chrono::seconds(30));
        if (!raised) client.look_again();
    }
}

}  // namespace

awaitable<void> serve_live(std::shared_ptr<Stream> stream, beast::http::request<beast::http::empty_body> upgrade,
                           ServerContext& context, LiveBody wish, std::shared_ptr<WakeUp> wake_up) {
    const Counted counted(context.metrics.live_clients);
    const auto connection = std::make_shared<Connection>(std::move(stream), context, std::move(wish), wake_up);
    connection->stream->expires_never();  // the WebSocket has deadlines of its own
    set_options(*connection, offers_live_protocol(upgrade));
    co_await connection->socket.async_accept(upgrade, use_awaitable);
    connection->socket.binary(true);
    asio::co_spawn(connection->socket.get_executor(), read_client(connection), asio::detached);

    const CloseAtEnd close_at_end(*connection);
    const websocket::close_code code = co_await follow(*connection);
    if (code == websocket::close_code::none) co_return;
    ErrorCode ignored;  // a client that does not answer the close frame in time is gone as well
    connection->stream->expires_after(std::chrono::seconds(3));
    co_await connection->socket.async_close(code, asio::redirect_error(use_awaitable, ignored));
}

}  // namespace anyrate
