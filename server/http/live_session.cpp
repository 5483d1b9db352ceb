#include "server/http/live_session.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "server/http/deadline.h"
#include "server/http/live_cursor.h"
#include "server/http/on_pool.h"

namespace anyrate {
namespace {

namespace websocket = beast::websocket;

/// One upgraded connection. Its coroutines run on one strand.
struct Connection {
    Connection(TcpStream stream, ServerContext& server, LiveBody asked, std::shared_ptr<WakeUp> news)
        : socket(std::move(stream)),
          context(server),
          wish(std::move(asked)),
          wake_up(std::move(news)),
          cursor(wish.from, wish.max_vertices) {}

    websocket::stream<TcpStream> socket;
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
    ~CloseAtEnd() {
        ErrorCode ignored;  // it is closed either way
        beast::get_lowest_layer(connection_.socket).socket().close(ignored);
    }
    CloseAtEnd(const CloseAtEnd&) = delete;
    CloseAtEnd& operator=(const CloseAtEnd&) = delete;

private:
    Connection& connection_;
};

/// What the catalog and the log say at one moment.
struct Snapshot {
    std::optional<ModelRecord> model;
    std::optional<LogView> log;
};

Snapshot look_up(Service& service, const std::string& id) {
    // The model first: if it is final then, its log is whole.
    Snapshot snapshot{.model = service.catalog.find(id), .log = std::nullopt};
    if (snapshot.model) snapshot.log = service.store.open_live_log(id);
    return snapshot;
}

void set_options(websocket::stream<TcpStream>& socket) {
    socket.set_option(websocket::stream_base::timeout{.handshake_timeout = std::chrono::seconds(10),
                                                      .idle_timeout = std::chrono::seconds(120),
                                                      .keep_alive_pings = true});
    socket.set_option(websocket::stream_base::decorator(
        [](websocket::response_type& response) { response.set(beast::http::field::server, "anyrate"); }));
    socket.read_message_max(4096);
    socket.write_buffer_bytes(8 * 1024);
}

/// @return false if the message is none that a client may send
bool apply_client_message(Connection& connection, const std::string& text) {
    const auto message = nlohmann::json::parse(text, nullptr, false);
    if (!message.is_object()) return false;
    if (const auto vertices = message.find("vertices"); vertices != message.end()) {
        if (!vertices->is_number_unsigned() || *vertices > UINT32_MAX) return false;
        connection.cursor.set_max_vertices(vertices->get<std::uint32_t>());
    }
    if (const auto pause = message.find("pause"); pause != message.end()) {
        if (!pause->is_boolean()) return false;
        connection.is_paused = pause->get<bool>();
    }
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

/// Sends one message; a client that takes nothing for the write patience loses its connection.
awaitable<void> send(Connection& connection, asio::const_buffer message, bool is_text) {
    const Deadline deadline(connection.socket.get_executor(), connection.context.limits.write_patience,
                            [&connection] { beast::get_lowest_layer(connection.socket).socket().close(); });
    connection.socket.text(is_text);
    co_await connection.socket.async_write(message, use_awaitable);
}

awaitable<void> send_text(Connection& connection, std::string text) {
    co_await send(connection, asio::buffer(text), true);
}

/// Sends what the client has not yet of this view. @return whether that was all there will ever be
awaitable<bool> send_frames(Connection& connection, const LogView& log) {
    const std::size_t n_bytes = connection.context.limits.live_message_bytes;
    if (connection.cursor.log_id() != log.log_id) {
        std::string hello = connection.cursor.hello(log);
        co_await send_text(connection, std::move(hello));
    }
    while (!connection.is_gone && !connection.is_paused) {
        const auto message = co_await on_pool(connection.context.quick_pool,
                                              [&] { return connection.cursor.next_message(log, n_bytes); });
        if (!message) break;
        co_await send(connection, asio::buffer(*message), false);
    }
    co_return !connection.is_paused && connection.cursor.is_complete(log);
}

std::string end_message(const std::optional<ModelRecord>& model) {
    nlohmann::ordered_json end = {{"type", "end"}, {"state", model ? state_name(model->state) : "deleted"}};
    if (model && !model->error.empty()) end["error"] = model->error;
    return end.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// Follows the model until there is a reason to end. @return the reason
awaitable<websocket::close_code> follow(Connection& connection) {
    for (;;) {
        if (connection.is_gone) co_return websocket::close_code::none;
        if (connection.context.sessions.is_draining()) co_return websocket::close_code::going_away;
        const Snapshot now = co_await on_pool(connection.context.quick_pool, [&] {
            return look_up(connection.context.service, connection.wish.model_id);
        });
        bool is_complete = false;
        if (now.log) is_complete = co_await send_frames(connection, *now.log);
        const bool is_over = !now.model || is_final(now.model->state);
        const bool is_sealed = now.log && now.log->complete;
        // A log is sealed a moment before the catalog hears of it: who is told the end finds it there, too.
        if (is_sealed ? is_complete && is_over : is_complete || is_over) {
            std::string end = end_message(now.model);
            co_await send_text(connection, std::move(end));
            co_return websocket::close_code::normal;
        }
        co_await connection.wake_up->wait(std::chrono::seconds(30));
    }
}

}  // namespace

awaitable<void> serve_live(TcpStream stream, beast::http::request<beast::http::empty_body> upgrade,
                           ServerContext& context, LiveBody wish, std::shared_ptr<WakeUp> wake_up) {
    const auto connection = std::make_shared<Connection>(std::move(stream), context, std::move(wish), wake_up);
    const ModelEvents::Subscription subscription(context.events, connection->wish.model_id,
                                                 [wake_up] { wake_up->raise(); });
    beast::get_lowest_layer(connection->socket).expires_never();  // the WebSocket has deadlines of its own
    set_options(connection->socket);
    co_await connection->socket.async_accept(upgrade, use_awaitable);
    connection->socket.binary(true);
    asio::co_spawn(connection->socket.get_executor(), read_client(connection), asio::detached);

    const CloseAtEnd close_at_end(*connection);
    const websocket::close_code code = co_await follow(*connection);
    ErrorCode ignored;  // a client that does not answer the close frame in time is gone as well
    const Deadline deadline(connection->socket.get_executor(), std::chrono::seconds(3),
                            [&connection] { beast::get_lowest_layer(connection->socket).socket().close(); });
    if (code != websocket::close_code::none)
        co_await connection->socket.async_close(code, asio::redirect_error(use_awaitable, ignored));
}

}  // namespace anyrate
