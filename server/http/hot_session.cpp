#include "server/http/hot_session.h"

#include <boost/asio/redirect_error.hpp>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/http/hot_path.h"
#include "server/http/metrics.h"
#include "server/http/response_writer.h"

namespace anyrate {
namespace {

std::string_view received(const HttpConnection& connection) {
    return {static_cast<const char*>(connection.buffer.data().data()), connection.buffer.size()};
}

void count_hot(Metrics& metrics, RouteMetrics& counted, std::uint64_t n_bytes,
               std::chrono::steady_clock::time_point begun) {
    counted.by_class[2].fetch_add(1, std::memory_order_relaxed);
    counted.seconds.observe(std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
    metrics.sent_bytes.fetch_add(n_bytes, std::memory_order_relaxed);
}

}  // namespace

bool may_serve_hot(const HttpConnection& connection) {
    const ServerContext& context = connection.context;
    const bool is_logged = context.log_access && context.log_from_status <= 206;
    return !connection.stream->is_tls() && !context.access.is_private && context.cors_origins.empty() && !is_logged;
}

awaitable<bool> serve_hot(HttpConnection& connection) {
    ServerContext& context = connection.context;
    RouteMetrics& counted = *context.metrics.routes[context.hot_route];
    std::string header;
    for (;;) {
        if (connection.buffer.size() > 0) {
            if (context.sessions.is_draining()) co_return true;
            const auto answer = answer_hot(received(connection), context.service.hot_logs, header);
            if (!answer) co_return true;
            connection.buffer.consume(answer->n_request_bytes);
            // Most answers go at once; no coroutine is made for those.
            const auto begun = std::chrono::steady_clock::now();
            std::size_t n_sent = 0;
            if (!write_now(*connection.stream, header, answer->body, n_sent))
                co_await write_rest(*connection.stream, header, answer->body, n_sent, context.limits.write_patience);
            count_hot(context.metrics, counted, answer->body.n_bytes, begun);
            continue;
        }
        connection.stream->expires_after(context.limits.header_patience);
        connection.is_idle = true;
        ErrorCode error;
        const std::size_t n = co_await connection.stream->async_read_some(connection.buffer.prepare(4096),
                                                                          asio::redirect_error(use_awaitable, error));
        connection.is_idle = false;
        if (error) co_return false;
        connection.buffer.commit(n);
    }
}

}  // namespace anyrate
