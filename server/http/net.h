#pragma once
// Names of the network library, for the files that own sockets.
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/tcp_stream.hpp>

namespace anyrate {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::awaitable;
using asio::use_awaitable;
using asio::ip::tcp;
using TcpStream = beast::tcp_stream;
using ErrorCode = boost::system::error_code;

}  // namespace anyrate
