#include "server/http/network_threads.h"

#include <doctest/doctest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <future>
#include <thread>
#include <vector>

using namespace anyrate;

namespace {

/// Two ends of a connection on this machine.
struct LoopbackConnection {
    asio::io_context loop;
    tcp::acceptor acceptor{loop, tcp::endpoint(asio::ip::address_v4::loopback(), 0)};
    tcp::socket client{loop}, accepted{loop};

    LoopbackConnection() {
        client.connect(acceptor.local_endpoint());
        acceptor.accept(accepted);
    }
};

awaitable<void> wait_for(std::shared_future<void> end, asio::io_context& loop) {
    while (end.wait_for(std::chrono::seconds(0)) != std::future_status::ready) co_await asio::post(loop, use_awaitable);
}

}  // namespace

TEST_CASE("Network threads: without a home the one with the fewest connections gets the next") {
    const std::vector<std::size_t> n_connections = {5, 3, 4};
    CHECK(choose_thread(n_connections, std::nullopt) == 1);
}

TEST_CASE("Network threads: the home gets the next until it has many more than another") {
    CHECK(choose_thread(std::vector<std::size_t>{0, 0}, 1) == 1);
    CHECK(choose_thread(std::vector<std::size_t>{1000, 1032}, 1) == 1);
    CHECK(choose_thread(std::vector<std::size_t>{1000, 1100}, 1) == 0);
    CHECK(choose_thread(std::vector<std::size_t>{1000, 1100, 990}, 1) == 2);
}

TEST_CASE("Network threads: any number of them takes connections, and counts each until it ends") {
    const auto n_processors = static_cast<int>(std::thread::hardware_concurrency());
    for (const int n : {1, n_processors, n_processors + 1}) {
        CAPTURE(n);
        LoopbackConnection connection;
        NetworkThreads threads(n);
        NetworkThread& chosen = threads.of(connection.accepted);
        std::promise<void> end;
        chosen.run(wait_for(end.get_future().share(), chosen.loop()));
        threads.start();
        CHECK(chosen.n_connections() == 1);
        end.set_value();
        while (chosen.n_connections() > 0) std::this_thread::yield();
        threads.stop();
    }
}
