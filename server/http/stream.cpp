#include "server/http/stream.h"

#include <boost/asio/redirect_error.hpp>

#include "server/http/tcp_progress.h"

namespace anyrate {
namespace {

constexpr std::uint64_t least_progress = 4096;

/// Waits that follow one another more closely are one: a client may ask for more without taking what it has been sent.
constexpr auto longest_pause = 4 * Deadlines::interval;

}  // namespace

void Deadlines::enforce(std::chrono::steady_clock::time_point now) {
    for (Stream* stream : streams_) stream->enforce(now);
}

Stream::Stream(tcp::socket socket, Deadlines& deadlines, asio::ssl::context* tls)
    : socket_(std::move(socket)), deadlines_(deadlines) {
    if (tls) tls_ = std::make_unique<asio::ssl::stream<tcp::socket&>>(socket_, *tls);
    position_ = deadlines_.streams_.insert(deadlines_.streams_.end(), this);
}

Stream::~Stream() { deadlines_.streams_.erase(position_); }

awaitable<void> Stream::handshake() {
    if (tls_) co_await tls_->async_handshake(asio::ssl::stream_base::server, use_awaitable);
}

awaitable<void> Stream::send_end() {
    ErrorCode ignored;  // the connection ends either way
    if (tls_) {
        // Asio's shutdown waits for the client's as well; its deadline is the caller's.
        co_await tls_->async_shutdown(asio::redirect_error(use_awaitable, ignored));
    }
    socket_.shutdown(tcp::socket::shutdown_send, ignored);
}

void Stream::cancel() {
    ErrorCode ignored;  // a socket that is closed has nothing to cancel
    socket_.cancel(ignored);
}

void Stream::close() {
    ErrorCode ignored;  // it is closed either way
    socket_.close(ignored);
}

void Stream::expires_after(Duration patience) {
    has_expired_ = false;
    progress_patience_.reset();
    deadline_ = std::chrono::steady_clock::now() + patience;
}

void Stream::expires_without_progress(Duration patience) {
    const auto now = std::chrono::steady_clock::now();
    has_expired_ = false;
    progress_patience_ = patience;
    deadline_ = look_at_progress(now) + patience;
}

std::chrono::steady_clock::time_point Stream::look_at_progress(std::chrono::steady_clock::time_point now) {
    const TcpProgress progress = tcp_progress(socket_.native_handle());
    const bool begins = now - looked_at_ > longest_pause;
    if (begins || progress.owes_nothing || progress.n_acknowledged >= n_acknowledged_ + least_progress) {
        progress_at_ = now;
        n_acknowledged_ = progress.n_acknowledged;
    }
    looked_at_ = now;
    return progress_at_;
}

void Stream::enforce(std::chrono::steady_clock::time_point now) {
    if (!deadline_) return;
    if (progress_patience_) deadline_ = look_at_progress(now) + *progress_patience_;
    if (now < *deadline_) return;
    deadline_.reset();
    has_expired_ = true;
    cancel();
}

}  // namespace anyrate
