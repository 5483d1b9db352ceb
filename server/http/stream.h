#pragma once
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/role.hpp>
#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <utility>

#include "server/http/net.h"

namespace anyrate {

class Stream;

/// Ends waits that take too long, for all connections of one network thread: one list that is looked through a few
/// times a second costs less than a timer for every wait. Used on that thread only.
class Deadlines {
public:
    static constexpr auto interval = std::chrono::milliseconds(250);  ///< between two calls of enforce()

    void enforce(std::chrono::steady_clock::time_point now);

private:
    friend class Stream;
    std::list<Stream*> streams_;
};

/// A client's connection: TCP, or TLS over it. A stream as Asio and Beast know them that stays where it was made.
/// A wait that meets its deadline ends as cancelled, and has_expired() tells.
class Stream {
public:
    using executor_type = tcp::socket::executor_type;
    using Duration = std::chrono::steady_clock::duration;

    /// @param deadlines  of the thread that runs the socket's executor; outlives the stream
    /// @param tls        nullptr for plain TCP; outlives the stream
    Stream(tcp::socket socket, Deadlines& deadlines, asio::ssl::context* tls);
    ~Stream();
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    executor_type get_executor() { return socket_.get_executor(); }
    tcp::socket& socket() { return socket_; }
    bool is_tls() const { return tls_ != nullptr; }

    /// TLS's greeting; nothing over plain TCP. @throws boost::system::system_error
    awaitable<void> handshake();
    /// Tells the client that nothing more will come, so that it does not take a cut for the end.
    awaitable<void> send_end();
    void cancel();
    void close();

    void expires_after(Duration patience);
    /// The deadline moves on whenever the client has acknowledged another 4 KB: it is for one that takes next to
    /// nothing. For one that has not acknowledged all it was sent, the next such wait goes on with the same deadline.
    void expires_without_progress(Duration patience);
    void expires_never() { deadline_.reset(); }
    bool has_expired() const { return has_expired_; }

    template <class Buffers, class Token>
    auto async_read_some(const Buffers& buffers, Token&& token) {
        return tls_ ? tls_->async_read_some(buffers, std::forward<Token>(token))
                    : socket_.async_read_some(buffers, std::forward<Token>(token));
    }
    template <class Buffers, class Token>
    auto async_write_some(const Buffers& buffers, Token&& token) {
        return tls_ ? tls_->async_write_some(buffers, std::forward<Token>(token))
                    : socket_.async_write_some(buffers, std::forward<Token>(token));
    }

    // What Beast's WebSocket needs of a stream to end it.
    friend void teardown(beast::role_type, Stream& stream, ErrorCode& error) {
        stream.socket_.shutdown(tcp::socket::shutdown_both, error);
    }
    template <class Handler>
    friend void async_teardown(beast::role_type, Stream& stream, Handler&& handler) {
        ErrorCode error;  // the close frames were exchanged, so nothing is lost with what may be under way
        stream.socket_.shutdown(tcp::socket::shutdown_send, error);
        asio::post(stream.get_executor(),
                   [handler = std::forward<Handler>(handler), error]() mutable { handler(error); });
    }
    friend void beast_close_socket(Stream& stream) { stream.close(); }

private:
    friend class Deadlines;
    void enforce(std::chrono::steady_clock::time_point now);
    /// @return when the client last made progress
    std::chrono::steady_clock::time_point look_at_progress(std::chrono::steady_clock::time_point now);

    tcp::socket socket_;
    std::unique_ptr<asio::ssl::stream<tcp::socket&>> tls_;
    Deadlines& deadlines_;
    std::list<Stream*>::iterator position_;
    std::optional<std::chrono::steady_clock::time_point> deadline_;
    std::optional<Duration> progress_patience_;  ///< set while progress moves the deadline
    // Kept from one wait to the next: when progress was looked at, and when and where there was some.
    std::chrono::steady_clock::time_point looked_at_, progress_at_;
    std::uint64_t n_acknowledged_ = 0;
    bool has_expired_ = false;
};

}  // namespace anyrate
