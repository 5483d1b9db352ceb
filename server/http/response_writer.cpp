#include "server/http/response_writer.h"

#include <sys/sendfile.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http/status.hpp>
#include <cerrno>
#include <string>

#include "server/http/http_date.h"
#include "server/http/problem.h"

namespace anyrate {
namespace {

std::string reason(int status) {
    const auto known = beast::http::obsolete_reason(static_cast<beast::http::status>(status));
    return known == "<unknown-status>" ? status_phrase(status) : std::string(known);
}

/// Status line and fields, without the empty line.
std::string common_header(const Response& response) {
    std::string header;
    header.reserve(512);
    header += "HTTP/1.1 ";
    header += std::to_string(response.status);
    header += ' ';
    header += reason(response.status);
    header += "\r\nServer: anyrate\r\nDate: ";
    header += http_date();
    header += "\r\nX-Content-Type-Options: nosniff\r\n";
    for (const auto& [name, value] : response.headers) {
        header += name;
        header += ": ";
        header += value;
        header += "\r\n";
    }
    return header;
}

bool may_have_body(int status) { return status >= 200 && status != 204 && status != 304; }

/// Longer bodies are sent from the page cache, without being copied; shorter ones cost less when they are copied.
constexpr std::uint64_t max_copied = 64 * 1024;

/// The body as it lies in memory, if it does and is short.
std::optional<asio::const_buffer> bytes_in_memory(const Response& response) {
    if (const auto* text = std::get_if<std::string>(&response.body)) return asio::buffer(*text);
    const auto& file = std::get<FileBody>(response.body);
    if (!file.memory || file.n_bytes > max_copied) return std::nullopt;
    return asio::buffer(file.memory->data() + file.begin, file.n_bytes);
}

[[noreturn]] void throw_errno(int error) {
    throw boost::system::system_error(ErrorCode(error, boost::system::system_category()));
}

/// Waits until the socket takes more. The kernel says so only when a third of its buffer is free again.
awaitable<void> wait_until_writable(Stream& stream) {
    co_await stream.socket().async_wait(tcp::socket::wait_write, use_awaitable);
}

awaitable<void> write_file(Stream& stream, const FileBody& body) {
    constexpr std::uint64_t piece = 1 << 20;
    off_t offset = static_cast<off_t>(body.begin);
    std::uint64_t left = body.n_bytes;
    while (left > 0) {
        const ssize_t sent = ::sendfile(stream.socket().native_handle(), body.file->get(), &offset,
                                        static_cast<std::size_t>(std::min(left, piece)));
        if (sent > 0) {
            left -= static_cast<std::uint64_t>(sent);
        } else if (sent < 0 && errno == EAGAIN) {
            co_await wait_until_writable(stream);
        } else if (sent == 0 || errno != EINTR) {
            throw_errno(sent == 0 ? EIO : errno);  // 0: the file is shorter than it was
        }
    }
}

/// What sendfile() does, for a connection whose bytes are encrypted here.
awaitable<void> copy_file(Stream& stream, const FileBody& body) {
    constexpr std::uint64_t piece = 64 * 1024;
    for (std::uint64_t done = 0; done < body.n_bytes;) {
        const auto n = static_cast<std::size_t>(std::min(piece, body.n_bytes - done));
        const auto bytes = read_at(*body.file, body.begin + done, n);
        if (bytes.size() < n) throw_errno(EIO);
        co_await asio::async_write(stream, asio::buffer(bytes), use_awaitable);
        done += n;
    }
}

/// Sends as much of header and body as the kernel takes now. @return how much of the two together
std::size_t send_now(Stream& stream, std::string_view header, asio::const_buffer body) {
    iovec parts[2] = {{const_cast<char*>(header.data()), header.size()}, {const_cast<void*>(body.data()), body.size()}};
    msghdr message{};
    message.msg_iov = parts;
    message.msg_iovlen = 2;
    const ssize_t sent = ::sendmsg(stream.socket().native_handle(), &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) throw_errno(errno);
    return sent < 0 ? 0 : static_cast<std::size_t>(sent);
}

/// Sends header and body but for their first `n_sent` bytes.
awaitable<void> write_rest(Stream& stream, std::string_view header, asio::const_buffer body, std::size_t n_sent) {
    const std::size_t of_header = std::min(n_sent, header.size());
    const std::array<asio::const_buffer, 2> parts = {asio::buffer(header.data(), header.size()) + of_header,
                                                     body + (n_sent - of_header)};
    co_await asio::async_write(stream, parts, use_awaitable);
}

/// Leaves the header in the kernel's buffer, so that it shares its packet with the first bytes of the body.
awaitable<void> write_header_of_file(Stream& stream, std::string_view header) {
    const ssize_t sent = ::send(stream.socket().native_handle(), header.data(), header.size(), MSG_MORE | MSG_NOSIGNAL);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) throw_errno(errno);
    if (sent > 0) header.remove_prefix(static_cast<std::size_t>(sent));
    if (!header.empty()) co_await asio::async_write(stream, asio::buffer(header.data(), header.size()), use_awaitable);
}

}  // namespace

std::uint64_t body_bytes(const Response& response) {
    if (const auto* file = std::get_if<FileBody>(&response.body)) return file->n_bytes;
    const auto* text = std::get_if<std::string>(&response.body);
    return text ? text->size() : 0;
}

awaitable<void> write_response(Stream& stream, const Response& response, const WriteOptions& options) {
    std::string header = common_header(response);
    if (may_have_body(response.status)) header += "Content-Length: " + std::to_string(body_bytes(response)) + "\r\n";
    if (!options.keep_alive) header += "Connection: close\r\n";
    header += "\r\n";
    stream.expires_without_progress(options.patience);
    if (!may_have_body(response.status) || options.head_only) {
        co_await asio::async_write(stream, asio::buffer(header), use_awaitable);
    } else if (const auto body = bytes_in_memory(response)) {
        const std::array<asio::const_buffer, 2> parts = {asio::buffer(header), *body};
        co_await asio::async_write(stream, parts, use_awaitable);
    } else if (stream.is_tls()) {
        co_await asio::async_write(stream, asio::buffer(header), use_awaitable);
        co_await copy_file(stream, std::get<FileBody>(response.body));
    } else {
        co_await write_header_of_file(stream, header);
        co_await write_file(stream, std::get<FileBody>(response.body));
    }
    stream.expires_never();
}

bool write_now(Stream& stream, std::string_view header, const FileBody& body, std::size_t& n_sent) {
    n_sent = 0;
    if (!body.memory || body.n_bytes > max_copied) return false;
    n_sent = send_now(stream, header, asio::buffer(body.memory->data() + body.begin, body.n_bytes));
    return n_sent == header.size() + body.n_bytes;
}

awaitable<void> write_rest(Stream& stream, std::string_view header, const FileBody& body, std::size_t n_sent,
                           std::chrono::seconds patience) {
    stream.expires_without_progress(patience);
    if (body.memory && body.n_bytes <= max_copied) {
        co_await write_rest(stream, header, asio::buffer(body.memory->data() + body.begin, body.n_bytes), n_sent);
    } else {
        co_await write_header_of_file(stream, header);
        co_await write_file(stream, body);
    }
    stream.expires_never();
}

awaitable<void> write_open_header(Stream& stream, const Response& response, std::chrono::seconds patience) {
    const std::string start = common_header(response) + "Connection: close\r\n\r\n";
    stream.expires_without_progress(patience);
    co_await asio::async_write(stream, asio::buffer(start), use_awaitable);
    stream.expires_never();
}

}  // namespace anyrate
