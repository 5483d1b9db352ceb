#include "server/http/response_writer.h"

#include <sys/sendfile.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http/status.hpp>
#include <cerrno>
#include <ctime>

#include "server/http/deadline.h"
#include "server/http/problem.h"

namespace anyrate {
namespace {

std::string reason(int status) {
    const auto known = beast::http::obsolete_reason(static_cast<beast::http::status>(status));
    return known == "<unknown-status>" ? status_phrase(status) : std::string(known);
}

std::string http_date() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    ::gmtime_r(&now, &utc);
    char text[40];
    std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &utc);
    return text;
}

/// Status line and fields, without the empty line.
std::string common_header(const Response& response) {
    std::string header = "HTTP/1.1 " + std::to_string(response.status) + " " + reason(response.status) + "\r\n";
    header += "Server: anyrate\r\nDate: " + http_date() + "\r\nX-Content-Type-Options: nosniff\r\n";
    for (const auto& [name, value] : response.headers) header += name + ": " + value + "\r\n";
    return header;
}

std::uint64_t body_bytes(const Response& response) {
    if (const auto* file = std::get_if<FileBody>(&response.body)) return file->n_bytes;
    return std::get<std::string>(response.body).size();
}

bool may_have_body(int status) { return status >= 200 && status != 204 && status != 304; }

awaitable<void> write_text(TcpStream& stream, const std::string& text, std::chrono::seconds patience) {
    // In pieces, so that patience is for a reader that takes nothing and not for a slow one.
    constexpr std::size_t piece = 64 * 1024;
    for (std::size_t at = 0; at < text.size(); at += piece) {
        stream.expires_after(patience);
        co_await asio::async_write(stream, asio::buffer(text.data() + at, std::min(piece, text.size() - at)),
                                   use_awaitable);
    }
    stream.expires_never();
}

awaitable<void> wait_until_writable(TcpStream& stream, std::chrono::seconds patience) {
    const Deadline deadline(stream.get_executor(), patience, [&stream] { stream.socket().cancel(); });
    co_await stream.socket().async_wait(tcp::socket::wait_write, use_awaitable);
}

awaitable<void> write_file(TcpStream& stream, const FileBody& body, std::chrono::seconds patience) {
    constexpr std::uint64_t piece = 1 << 20;
    stream.socket().native_non_blocking(true);
    off_t offset = static_cast<off_t>(body.begin);
    std::uint64_t left = body.n_bytes;
    while (left > 0) {
        const ssize_t sent = ::sendfile(stream.socket().native_handle(), body.file->get(), &offset,
                                        static_cast<std::size_t>(std::min(left, piece)));
        if (sent > 0) {
            left -= static_cast<std::uint64_t>(sent);
        } else if (sent < 0 && errno == EAGAIN) {
            co_await wait_until_writable(stream, patience);
        } else if (sent == 0 || errno != EINTR) {
            const int error = sent == 0 ? EIO : errno;  // 0: the file is shorter than it was
            throw boost::system::system_error(ErrorCode(error, boost::system::system_category()));
        }
    }
}

}  // namespace

awaitable<void> write_response(TcpStream& stream, const Response& response, const WriteOptions& options) {
    std::string start = common_header(response);
    if (may_have_body(response.status)) start += "Content-Length: " + std::to_string(body_bytes(response)) + "\r\n";
    if (!options.keep_alive) start += "Connection: close\r\n";
    start += "\r\n";
    const bool with_body = may_have_body(response.status) && !options.head_only;
    const auto* text = std::get_if<std::string>(&response.body);
    if (with_body && text) start += *text;
    co_await write_text(stream, start, options.patience);
    if (with_body && !text) co_await write_file(stream, std::get<FileBody>(response.body), options.patience);
}

awaitable<void> write_open_header(TcpStream& stream, const Response& response, std::chrono::seconds patience) {
    const std::string start = common_header(response) + "Connection: close\r\n\r\n";
    co_await write_text(stream, start, patience);
}

}  // namespace anyrate
