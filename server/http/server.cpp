#include "server/http/server.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/thread_pool.hpp>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.h"
#include "server/http/context.h"
#include "server/http/http_session.h"
#include "server/store/sqlite_catalog.h"

namespace anyrate {
namespace {

constexpr auto drain_patience = std::chrono::seconds(20);

tcp::endpoint endpoint_of(const ServerOptions& options) {
    ErrorCode error;
    const auto address = asio::ip::make_address(options.address, error);
    if (error) throw InputError("\"" + options.address + "\" is not an IP address");
    if (!address.is_loopback() && options.token.empty())
        throw InputError("listening on " + options.address +
                         " needs a token (--token or ANYRATE_TOKEN): without one the server serves this machine only");
    return {address, options.port};
}

tcp::acceptor listen(asio::io_context& context, const tcp::endpoint& endpoint) {
    try {
        tcp::acceptor acceptor(asio::make_strand(context));
        acceptor.open(endpoint.protocol());
        acceptor.set_option(asio::socket_base::reuse_address(true));
        acceptor.bind(endpoint);
        acceptor.listen();
        return acceptor;
    } catch (const boost::system::system_error& error) {
        throw IoError("cannot listen on " + endpoint.address().to_string() + ":" + std::to_string(endpoint.port()) +
                      ": " + error.code().message());
    }
}

awaitable<void> pause(asio::any_io_executor executor) {
    asio::steady_timer timer(executor, std::chrono::milliseconds(50));
    co_await timer.async_wait(use_awaitable);
}

/// Accepts connections until the acceptor is closed; each lives on a strand of its own.
awaitable<void> accept_connections(tcp::acceptor& acceptor, asio::io_context& io, ServerContext& context) {
    while (acceptor.is_open()) {
        if (context.sessions.count() >= context.limits.max_connections) {
            co_await pause(acceptor.get_executor());
            continue;
        }
        tcp::socket socket(asio::make_strand(io));
        ErrorCode error;
        co_await acceptor.async_accept(socket, asio::redirect_error(use_awaitable, error));
        if (error == asio::error::operation_aborted) co_return;
        if (error) {  // out of descriptors, or the peer is gone again
            co_await pause(acceptor.get_executor());
            continue;
        }
        socket.set_option(tcp::no_delay(true), error);
        const auto executor = socket.get_executor();
        asio::co_spawn(executor, serve_connection(std::move(socket), context), asio::detached);
    }
}

void wait_for(std::stop_token stop) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    stopped.wait(lock, stop, [] { return false; });
}

HttpLimits limits_of(const ServerOptions& options) {
    HttpLimits limits;
    limits.max_upload_bytes = options.max_upload_bytes;
    return limits;
}

}  // namespace

// Members are destroyed from the last to the first: threads before what they use.
struct Server::State {
    explicit State(ServerOptions given)
        : options(std::move(given)),
          endpoint(endpoint_of(options)),
          store(options.data),
          catalog(store.catalog_file()),
          acceptor(listen(io, endpoint)) {
        store.remove_leftovers([this](const std::string& id) { return catalog.find(id).has_value(); });
    }
    ~State() { join(); }

    void join() {
        quick_pool.join();
        heavy_pool.join();
        io.stop();
        threads.clear();
    }

    ServerOptions options;
    tcp::endpoint endpoint;
    ModelStore store;
    SqliteCatalog catalog;
    ModelEvents events;
    asio::io_context io;
    tcp::acceptor acceptor;  // before the scheduler: a port that is taken is found before a job begins
    Scheduler scheduler{catalog, events, options.worker_command, options.jobs, options.log};
    Service service{.catalog = catalog,
                    .store = store,
                    .on_queued = [this] { scheduler.wake(); },
                    .on_removed =
                        [this](const std::string& id) {
                            scheduler.abandon(id);
                            events.notify(id);
                        },
                    .viewer = ViewerFiles::load(options.viewer)};
    Router router = make_router(service);
    Sessions sessions;
    asio::thread_pool quick_pool{4};
    asio::thread_pool heavy_pool{1};
    ServerContext context{.service = service,
                          .router = router,
                          .events = events,
                          .sessions = sessions,
                          .quick_pool = quick_pool,
                          .heavy_pool = heavy_pool,
                          .limits = limits_of(options),
                          .token = options.token,
                          .log = options.log};
    std::vector<std::jthread> threads;
};

Server::Server(ServerOptions options) {
    // sendfile() to a client that is gone raises it; the error it returns says the same.
    std::signal(SIGPIPE, SIG_IGN);
    state_ = std::make_unique<State>(std::move(options));
}

Server::~Server() = default;

std::string Server::url() const {
    const auto endpoint = state_->acceptor.local_endpoint();
    const std::string address = endpoint.address().to_string();
    return "http://" + (endpoint.address().is_v6() ? "[" + address + "]" : address) + ":" +
           std::to_string(endpoint.port());
}

void Server::run(std::stop_token stop) {
    State& state = *state_;
    asio::co_spawn(state.acceptor.get_executor(), accept_connections(state.acceptor, state.io, state.context),
                   asio::detached);
    for (int i = 0; i < state.options.n_network_threads; ++i) state.threads.emplace_back([&state] { state.io.run(); });
    wait_for(stop);

    asio::post(state.acceptor.get_executor(), [&state] { state.acceptor.close(); });
    state.sessions.drain();
    state.scheduler.stop();
    if (!state.sessions.wait_until_empty(drain_patience)) state.options.log("connections were cut at the end");
    state.join();
}

}  // namespace anyrate
