#include "server/http/events_session.h"

#include <boost/asio/write.hpp>
#include <optional>
#include <string>

#include "server/http/model_json.h"
#include "server/http/on_pool.h"
#include "server/http/response_writer.h"

namespace anyrate {
namespace {

struct News {
    std::string json;
    bool is_last = false;
};

std::optional<News> look_up(Service& service, const std::string& id) {
    const auto model = service.catalog.find(id);
    if (!model) return std::nullopt;
    return News{model_json(*model), is_final(model->state)};
}

awaitable<void> send(Stream& stream, std::string text, std::chrono::seconds patience) {
    stream.expires_without_progress(patience);
    co_await asio::async_write(stream, asio::buffer(text), use_awaitable);
    stream.expires_never();
}

}  // namespace

awaitable<void> serve_events(Stream& stream, ServerContext& context, const Response& response,
                             std::shared_ptr<WakeUp> wake_up) {
    constexpr auto heartbeat = std::chrono::seconds(15);  // finds connections that are gone
    const Counted counted(context.metrics.event_clients);
    const std::string id = std::get<EventsBody>(response.body).model_id;
    const ModelEvents::Subscription subscription(context.events, id, [wake_up] { wake_up->raise(); });
    co_await write_open_header(stream, response, context.limits.write_patience);

    std::string last;
    while (!context.sessions.is_draining()) {
        const std::optional<News> news =
            co_await on_pool(context.quick_pool, [&] { return look_up(context.service, id); });
        if (!news) {
            co_await send(stream, "event: deleted\ndata: {}\n\n", context.limits.write_patience);
            co_return;
        }
        if (news->json != last)  // the JSON is one line with its line feed
            co_await send(stream, "event: state\ndata: " + news->json + "\n", context.limits.write_patience);
        last = news->json;
        if (news->is_last) co_return;
        const bool raised = co_await wake_up->wait(heartbeat);
        if (!raised) co_await send(stream, ": still here\n\n", context.limits.write_patience);
    }
}

}  // namespace anyrate
