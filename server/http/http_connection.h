#pragma once
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <memory>
#include <string>
#include <utility>

#include "server/http/context.h"
#include "server/http/net.h"
#include "server/http/network_thread.h"
#include "server/http/stream.h"
#include "server/http/wake_up.h"

namespace anyrate {

/// One connection between two requests and while one is served. Lives on one network thread.
struct HttpConnection {
    HttpConnection(tcp::socket socket, NetworkThread& thread, asio::ssl::context* tls, ServerContext& server)
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

}  // namespace anyrate
