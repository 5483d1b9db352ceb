#include "server/http/server.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <condition_variable>
#include <csignal>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"
#include "server/http/context.h"
#include "server/http/hot_logs.h"
#include "server/http/http_session.h"
#include "server/http/network_threads.h"
#include "server/http/tokens.h"
#include "server/store/capture_store.h"
#include "server/store/sqlite_catalog.h"

namespace anyrate {
namespace {

constexpr auto drain_patience = std::chrono::seconds(20);
constexpr auto housekeeping_interval = std::chrono::seconds(10);

tcp::endpoint endpoint_of(const ServerOptions& options) {
    ErrorCode error;
    const auto address = asio::ip::make_address(options.address, error);
    if (error) throw InputError("\"" + options.address + "\" is not an IP address");
    return {address, options.port};
}

void expect_safe(const ServerOptions& options, const tcp::endpoint& endpoint, Tokens& tokens) {
    if (!endpoint.address().is_loopback() && !tokens.has_writer())
        throw InputError("listening on " + options.address +
                         " needs a token (anyrate token, --token or ANYRATE_TOKEN): without one the server serves this "
                         "machine only");
}

/// @return nullopt for plain HTTP @throws InputError
std::optional<asio::ssl::context> tls_of(const ServerOptions& options) {
    if (options.tls_certificate.empty() && options.tls_key.empty()) return std::nullopt;
    if (options.tls_certificate.empty() || options.tls_key.empty())
        throw InputError("TLS needs both a certificate (--tls-certificate) and its key (--tls-key)");
    std::optional<asio::ssl::context> tls(std::in_place, asio::ssl::context::tls_server);
    tls->set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 |
                     asio::ssl::context::no_tlsv1_1);
    ErrorCode error;
    tls->use_certificate_chain_file(options.tls_certificate.string(), error);
    if (error) throw InputError(options.tls_certificate.string() + ": no certificate chain in PEM: " + error.message());
    tls->use_private_key_file(options.tls_key.string(), asio::ssl::context::pem, error);
    if (error) throw InputError(options.tls_key.string() + ": no private key of the certificate: " + error.message());
    return tls;
}

tcp::acceptor listen(asio::io_context& context, const tcp::endpoint& endpoint) {
    try {
        tcp::acceptor acceptor(context);
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

/// Accepts connections until the acceptor is closed, and gives them to the threads.
awaitable<void> accept_connections(tcp::acceptor& acceptor, NetworkThreads& threads, asio::ssl::context* tls,
                                   ServerContext& context) {
    const auto protocol = acceptor.local_endpoint().protocol();
    while (acceptor.is_open()) {
        if (context.sessions.count() >= context.limits.max_connections) {
            co_await pause(acceptor.get_executor());
            continue;
        }
        tcp::socket accepted(acceptor.get_executor());
        ErrorCode error;
        co_await acceptor.async_accept(accepted, asio::redirect_error(use_awaitable, error));
        if (error == asio::error::operation_aborted) co_return;
        if (error) {  // out of descriptors, or the peer is gone again
            co_await pause(acceptor.get_executor());
            continue;
        }
        accepted.set_option(tcp::no_delay(true), error);
        NetworkThread& thread = threads.of(accepted);
        tcp::socket socket(thread.loop(), protocol, accepted.release());
        thread.run(serve_connection(std::move(socket), thread, tls, context));
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
    limits.max_connections = options.max_connections;
    return limits;
}

/// The counters of each route, and of requests that found none.
std::vector<std::unique_ptr<RouteMetrics>> metrics_of(const Router& router) {
    std::vector<std::unique_ptr<RouteMetrics>> metrics;
    const auto add = [&](const std::string& method, const std::string& pattern) {
        metrics.push_back(std::make_unique<RouteMetrics>());
        metrics.back()->method = method;
        metrics.back()->pattern = pattern;
    };
    for (const Route& route : router.routes()) add(route.method, route.pattern);
    add("", "");
    return metrics;
}

}  // namespace

/// Removes captures that nobody made a model of for long, now and every hour.
void watch_captures(asio::steady_timer& timer, asio::thread_pool& pool, CaptureStore& captures,
                    const ServerOptions& options) {
    asio::post(pool, [&] {
        const auto now = std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now());
        try {
            const int n = captures.remove_older(now - options.keep_captures);
            if (n > 0) options.log(std::to_string(n) + " old captures removed");
        } catch (const IoError& error) {
            options.log(std::string("captures: ") + error.what());
        }
    });
    timer.expires_after(std::chrono::hours(1));
    timer.async_wait([&](ErrorCode error) {
        if (!error) watch_captures(timer, pool, captures, options);
    });
}

// Members are destroyed from the last to the first: who uses before what is used.
struct Server::State {
    explicit State(ServerOptions given)
        : options(std::move(given)),
          endpoint(endpoint_of(options)),
          tls(tls_of(options)),
          store(options.data),
          captures(options.data),
          catalog(store.catalog_file()),
          threads(options.n_network_threads),
          acceptor(listen(threads.first().loop(), endpoint)) {
        expect_safe(options, endpoint, tokens);
        store.remove_leftovers([this](const std::string& id) { return catalog.find(id).has_value(); });
        metrics.routes = metrics_of(router);
        context.hot_route = router.number_of("/v1/models/{id}/log");
    }
    ~State() { join(); }

    void join() {
        quick_pool.join();
        heavy_pool.join();
        upload_pool.join();
        threads.stop();
    }

    SchedulerOptions counted_jobs() {
        SchedulerOptions jobs = options.jobs;
        jobs.on_stage = [this](const std::string& stage, double seconds) { metrics.stages.add(stage, seconds); };
        return jobs;
    }

    /// `anyrate gc` works on the same directory.
    void forget_what_others_removed() {
        for (const std::string& id : hot_logs.ids())
            if (!catalog.find(id)) hot_logs.forget(id);
    }

    std::function<JudgedCapture(const std::filesystem::path&)> judge() {
        if (!options.judge_command) return {};
        return [this](const std::filesystem::path& zip) { return judge_upload(options.judge_command(zip)); };
    }

    ServerOptions options;
    tcp::endpoint endpoint;
    std::optional<asio::ssl::context> tls;
    ModelStore store;
    CaptureStore captures;
    Tokens tokens{options.data / "tokens.json", options.token};
    SqliteCatalog catalog;
    ModelEvents events;
    HotLogs hot_logs;
    Metrics metrics;
    Sessions sessions;
    asio::thread_pool quick_pool{4};
    asio::thread_pool heavy_pool{1};
    asio::thread_pool upload_pool{4};
    Service service{.catalog = catalog,
                    .store = store,
                    .captures = captures,
                    .hot_logs = hot_logs,
                    .metrics = metrics,
                    .on_queued = [this] { scheduler->wake(); },
                    .on_removed =
                        [this](const std::string& id) {
                            hot_logs.forget(id);
                            scheduler->abandon(id);
                            events.notify(id);
                        },
                    .judge_zip = judge(),
                    .max_capture_bytes = options.max_upload_bytes,
                    .viewer = ViewerFiles::load(options.viewer)};
    Router router = make_router(service);
    LiveFeeds live_feeds{service, events, quick_pool};
    ServerContext context{
        .service = service,
        .router = router,
        .events = events,
        .sessions = sessions,
        .live_feeds = live_feeds,
        .metrics = metrics,
        .quick_pool = quick_pool,
        .heavy_pool = heavy_pool,
        .upload_pool = upload_pool,
        .limits = limits_of(options),
        .access = {tokens, options.is_private, !endpoint.address().is_loopback(), service.viewer != nullptr},
        .cors_origins = options.cors_origins,
        .log = options.log,
        .log_access = options.log_access,
        .log_from_status = options.log_from_status};
    NetworkThreads threads;
    asio::steady_timer capture_timer{threads.first().loop()};
    tcp::acceptor acceptor;  // before the scheduler: a port that is taken is found before a job begins
    std::optional<Scheduler> scheduler{std::in_place,          catalog,        events,
                                       options.worker_command, counted_jobs(), options.log};
    Housekeeper housekeeper{
        catalog, options.data, options.keep, housekeeping_interval, service.on_removed, options.log, [this] {
            forget_what_others_removed();
        }};
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
    return (state_->tls ? std::string("https://") : "http://") +
           (endpoint.address().is_v6() ? "[" + address + "]" : address) + ":" + std::to_string(endpoint.port());
}

void Server::run(std::stop_token stop) {
    State& state = *state_;
    asio::co_spawn(state.acceptor.get_executor(),
                   accept_connections(state.acceptor, state.threads, state.tls ? &*state.tls : nullptr, state.context),
                   asio::detached);
    watch_captures(state.capture_timer, state.quick_pool, state.captures, state.options);
    state.threads.start();
    wait_for(stop);

    asio::post(state.acceptor.get_executor(), [&state] { state.acceptor.close(); });
    state.sessions.drain();
    state.scheduler->stop();
    if (!state.sessions.wait_until_empty(drain_patience)) state.options.log("connections were cut at the end");
    state.join();
}

}  // namespace anyrate
