#pragma once
#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "server/client/server_access.h"
#include "server/client/url.h"

namespace anyrate {

/// A client's connection: TCP, or for https TLS over it, whose certificate is checked against the host's name. A stream
/// as Asio and Beast know them. Each step is one asynchronous operation run to its end on an io_context of its own.
class ClientStream {
public:
    using executor_type = boost::beast::tcp_stream::executor_type;
    using ErrorCode = boost::system::error_code;

    /// @throws InputError `access.ca` holds no certificates
    ClientStream(boost::asio::io_context& io, const Url& server, const ServerAccess& access);

    /// Finds the host, connects, and greets. @throws IoError @throws UntrustedServer
    void connect(std::chrono::seconds patience);
    bool is_secure() const { return tls_ != nullptr; }

    executor_type get_executor() { return tcp_.get_executor(); }
    void expires_after(std::chrono::seconds patience) { tcp_.expires_after(patience); }
    void expires_never() { tcp_.expires_never(); }

    template <class Buffers, class Token>
    auto async_read_some(const Buffers& buffers, Token&& token) {
        return tls_ ? tls_->async_read_some(buffers, std::forward<Token>(token))
                    : tcp_.async_read_some(buffers, std::forward<Token>(token));
    }
    template <class Buffers, class Token>
    auto async_write_some(const Buffers& buffers, Token&& token) {
        return tls_ ? tls_->async_write_some(buffers, std::forward<Token>(token))
                    : tcp_.async_write_some(buffers, std::forward<Token>(token));
    }

    // What Beast's WebSocket needs of a stream to end it.
    friend void teardown(boost::beast::role_type, ClientStream& stream, ErrorCode& error) {
        stream.tcp_.socket().shutdown(boost::asio::socket_base::shutdown_both, error);
    }
    template <class Handler>
    friend void async_teardown(boost::beast::role_type, ClientStream& stream, Handler&& handler) {
        ErrorCode error;
        stream.tcp_.socket().shutdown(boost::asio::socket_base::shutdown_both, error);
        boost::asio::post(stream.get_executor(),
                          [handler = std::forward<Handler>(handler), error]() mutable { handler(error); });
    }
    friend void beast_close_socket(ClientStream& stream) { stream.tcp_.close(); }

private:
    template <class Start>
    ErrorCode run(const Start& start);

    boost::asio::io_context& io_;
    Url server_;
    boost::beast::tcp_stream tcp_;
    std::optional<boost::asio::ssl::context> trust_;
    std::unique_ptr<boost::asio::ssl::stream<boost::beast::tcp_stream&>> tls_;
};

}  // namespace anyrate
