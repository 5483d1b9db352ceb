// Live fan-out: many WebSocket clients of one model on this machine. Prints JSON.
//
//   fan_out --clients 1000                 frames at a steady rate: delay from the durable frame to each client
//   fan_out --clients 1000 --stalled 100   the same while some clients take nothing: the others' delay, the queues of
//                                          the stalled ones (/proc/net/tcp), and when they are dropped
//   fan_out --clients 1000 --catch-up 4    all ask for a log of 4 MB that is there already: MB/s, size of the messages
//   fan_out --clients 9000 --idle 600      nothing happens for so many seconds: bytes of the server for each client
//
// Server, worker and clients are processes of their own; the worker is a stand-in that writes frames of random bytes,
// which a server does not look into. Every client compares every byte.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "server/client/http_client.h"
#include "server/store/file.h"
#include "tests/bench/live_load.h"
#include "tests/bench/synthetic_log.h"
#include "tests/bench/synthetic_server.h"
#include "tests/bench/tool.h"

namespace fs = std::filesystem;
using namespace anyrate;
using namespace anyrate::bench;

namespace {

std::string make_model(const Url& server, const fs::path& data) {
    const fs::path zip = data / "capture.zip";
    replace_file(zip, as_bytes("PK\x03\x04"));
    HttpClient client(server);
    const ClientRequest request{
        .method = "POST", .target = "/v1/models", .headers = {{"Content-Type", "application/zip"}}, .body = zip};
    const ClientResponse response = client.open(request);
    if (response.status != 202) throw_problem(client, response);
    return response.location;
}

/// The fullest send queue of the server's connections, bytes.
std::uint64_t longest_queue(std::uint16_t port) {
    std::ifstream table("/proc/net/tcp");
    std::string line;
    std::getline(table, line);
    std::uint64_t longest = 0;
    while (std::getline(table, line)) {
        unsigned local_port = 0, state = 0;
        unsigned long queue = 0;
        if (std::sscanf(line.c_str(), " %*d: %*8X:%4X %*8X:%*4X %2X %8lX", &local_port, &state, &queue) == 3 &&
            local_port == port && state == 1)
            longest = std::max<std::uint64_t>(longest, queue);
    }
    return longest;
}

double metric(const Url& server, const std::string& name) {
    HttpClient client(server);
    ClientRequest request{.target = "/metrics", .headers = {}, .body = {}};
    if (client.open(request).status != 200) throw IoError("no metrics");
    std::istringstream lines(client.read_text());
    std::string line;
    while (std::getline(lines, line))
        if (line.rfind(name + " ", 0) == 0) return std::stod(line.substr(name.size() + 1));
    throw IoError("no metric " + name);
}

double quantile(std::vector<double>& sorted, double q) {
    return sorted.empty() ? 0 : sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
}

Json delays(const LiveLoad& load, const fs::path& stamps_file) {
    const auto raw = read_file(stamps_file);
    std::vector<std::int64_t> stamps(raw.size() / sizeof(std::int64_t));
    std::copy(raw.begin(), raw.end(), reinterpret_cast<std::byte*>(stamps.data()));
    std::vector<double> all;
    for (const LiveClient& client : load.clients)
        for (std::size_t i = 0; i < client.arrivals.size(); ++i)
            all.push_back(1e-6 * static_cast<double>(client.arrivals[i].time_since_epoch().count() - stamps[i]));
    std::sort(all.begin(), all.end());
    return {{"n", all.size()}, {"p50", quantile(all, 0.5)}, {"p99", quantile(all, 0.99)}, {"max", quantile(all, 1)}};
}

Json judge(const LiveLoad& load, const SyntheticLog& log) {
    int n_whole = 0, n_wrong = 0, n_reading = 0;
    std::uint64_t n_bytes = 0, n_messages = 0;
    for (const LiveClient& client : load.clients) {
        n_wrong += client.is_wrong;
        n_reading += !client.is_stalled;
        n_whole += !client.is_wrong && client.n_bytes == log.bytes.size();
        n_bytes += client.n_bytes;
        n_messages += client.n_messages;
    }
    return {{"clients_reading", n_reading},
            {"clients_with_every_byte", n_whole},
            {"clients_with_a_wrong_byte", n_wrong},
            {"bytes", n_bytes},
            {"bytes_per_message", n_messages ? n_bytes / n_messages : 0}};
}

/// Watches the queues until every stalled client was dropped.
Json watch_stalled(const ServerProcess& server, int n_stalled) {
    std::uint64_t longest = 0;
    double evicted = 0, seconds = 0;
    std::optional<Clock::time_point> full_at;
    const auto deadline = Clock::now() + std::chrono::seconds(90);
    while (evicted < n_stalled && Clock::now() < deadline) {
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        const std::uint64_t queue = longest_queue(server.port());
        // The last progress of a client that takes nothing was before its queue stopped to grow.
        if (queue > longest || !full_at) full_at = Clock::now();
        longest = std::max(longest, queue);
        evicted = metric(server.url(), "anyrate_live_evictions_total");
        seconds = std::chrono::duration<double>(Clock::now() - *full_at).count();
    }
    return {
        {"longest_queue_bytes", longest}, {"evicted", evicted}, {"seconds_from_full_queue_to_last_eviction", seconds}};
}

std::string cpu_name() {
    std::ifstream info("/proc/cpuinfo");
    std::string line;
    while (std::getline(info, line))
        if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
    return "unknown";
}

Json run(FanOutOptions options) {
    rlimit files{};
    ::getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = files.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &files);

    std::string folder = (fs::temp_directory_path() / "anyrate-fan-out-XXXXXX").string();
    if (!::mkdtemp(folder.data())) throw IoError("no temporary folder");
    options.data = folder;
    const SyntheticLog log = make_log(options);
    Json result = {{"machine", {{"cpu", cpu_name()}, {"cores", std::thread::hardware_concurrency()}}},
                   {"clients", options.n_clients}};
    {
        const ServerProcess server(options);
        const std::string model = make_model(server.url(), options.data);
        wait_for_file(options.data / "ready");
        const std::uint64_t memory_before = server.resident_bytes();
        LiveLoad load({.port = server.port(),
                       .target = model + "/live",
                       .n_clients = options.n_clients,
                       .n_stalled = options.n_stalled,
                       .log = log.bytes,
                       .frame_ends = log.frame_ends});
        auto begun = Clock::now();
        load.ask();
        load.wait_until_open(std::chrono::minutes(10));  // a busy machine
        if (options.idle_seconds > 0) {
            load.read_to_end(std::chrono::seconds(options.idle_seconds));
            int n_dropped = 0;
            for (const LiveClient& client : load.clients) n_dropped += client.has_ended;
            result["idle"] = {{"seconds", options.idle_seconds},
                              {"dropped", n_dropped},
                              {"server_bytes_per_client", (server.resident_bytes() - memory_before) /
                                                              static_cast<std::uint64_t>(options.n_clients)}};
            fs::remove_all(options.data);
            return result;
        }
        std::ofstream(options.data / "go").put('\n');
        if (options.n_stalled > 0) {
            // Beside the clients that read: what they wait is not to be the time that watching takes.
            auto watched = std::async(std::launch::async, [&] { return watch_stalled(server, options.n_stalled); });
            while (watched.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
                load.read_to_end(std::chrono::milliseconds(200));
            result["stalled"] = watched.get();
            std::ofstream(options.data / "enough").put('\n');
        }
        result["ended_in_time"] = load.read_to_end(std::chrono::seconds(static_cast<int>(options.seconds) + 60));
        result["log_bytes"] = log.bytes.size();
        result["received"] = judge(load, log);
        result["server_bytes_more"] = server.resident_bytes() - memory_before;
        if (options.catch_up_mb > 0) {
            auto last = begun;
            for (const LiveClient& client : load.clients) last = std::max(last, client.ended_at);
            const double seconds = std::chrono::duration<double>(last - begun).count();
            result["catch_up"] = {{"seconds", seconds},
                                  {"megabytes_per_second", result["received"]["bytes"].get<double>() / 1e6 / seconds}};
        } else {
            result["frame_bytes"] = options.frame_bytes;
            result["frames_per_second"] = options.frames_per_second;
            result["delay_ms"] = delays(load, options.data / "stamps");
        }
    }
    fs::remove_all(options.data);
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Sends one model's live log to many clients on this machine.", "fan_out");
    FanOutOptions options;
    app.add_option("--clients", options.n_clients, "live clients")->capture_default_str();
    app.add_option("--stalled", options.n_stalled, "of them that take nothing")->capture_default_str();
    app.add_option("--frame-bytes", options.frame_bytes, "of each frame")->capture_default_str();
    app.add_option("--frames-per-second", options.frames_per_second, "while the model is made")->capture_default_str();
    app.add_option("--seconds", options.seconds, "that the model takes")->capture_default_str();
    app.add_option("--catch-up", options.catch_up_mb, "MB of a log that is there when the clients come");
    app.add_option("--idle", options.idle_seconds, "seconds in which nothing happens");
    app.add_option("--worker-model", options.worker_model)->group("");
    app.add_option("--data", options.data)->group("");
    app.add_option("--parent", options.parent)->group("");
    // A worker's standard output is the server's.
    for (int i = 1; i < argc; ++i)
        if (std::string(argv[i]) == "--worker-model") {
            CLI11_PARSE(app, argc, argv);
            return run_synthetic_worker(options);
        }
    return run_tool(app, argc, argv, [&] { return run(options); });
}
