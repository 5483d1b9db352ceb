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
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "proto/header.h"
#include "proto/index.h"
#include "server/client/http_client.h"
#include "server/http/server.h"
#include "server/jobs/worker_message.h"
#include "server/store/live_log_file.h"
#include "server/store/model_store.h"
#include "tests/bench/live_load.h"
#include "tests/bench/tool.h"

namespace fs = std::filesystem;
using namespace anyrate;
using namespace anyrate::bench;

namespace {

struct Options {
    int n_clients = 1000, n_stalled = 0;
    int frame_bytes = 8192, frames_per_second = 20;
    double seconds = 10;
    int catch_up_mb = 0, idle_seconds = 0;
    // Of the stand-in for a worker.
    std::string worker_model;
    fs::path data;

    int n_frames() const {
        if (catch_up_mb > 0) return (catch_up_mb << 20) / frame_bytes;
        return std::max(1, static_cast<int>(seconds * frames_per_second));
    }
};

/// The live log that the worker writes and the clients expect.
struct SyntheticLog {
    std::vector<std::byte> bytes;
    std::vector<IndexRow> rows;
    std::vector<std::uint64_t> frame_ends;  ///< in the file
};

constexpr std::uint64_t log_id = 0x5EED;

SyntheticLog make_log(const Options& options) {
    Header header;
    header.log_id = log_id;
    header.grid = {.unit = 1.0, .bits = 14, .base_shift = 2};
    header.n_base_vertices = 6;
    header.n_base_faces = 8;
    SyntheticLog log{.bytes = encode_header(header), .rows = {}, .frame_ends = {}};
    std::mt19937_64 random(7);
    for (int i = 0; i < options.n_frames(); ++i) {
        for (int word = 0; word < options.frame_bytes / 8; ++word) {
            const std::uint64_t bits = random();
            const auto* begin = reinterpret_cast<const std::byte*>(&bits);
            log.bytes.insert(log.bytes.end(), begin, begin + 8);
        }
        log.frame_ends.push_back(log.bytes.size());
        log.rows.push_back({.n_vertices = 6 + 3 * static_cast<std::uint32_t>(i),
                            .end = static_cast<std::uint32_t>(log.bytes.size() - header_size),
                            .mean_distortion = 1.0f / static_cast<float>(i + 1),
                            .max_distortion = 1});
    }
    return log;
}

void tell(const WorkerMessage& message) {
    std::fputs(encode_worker_message(message).c_str(), stdout);
    std::fflush(stdout);
}

/// Waits for a file that another process makes.
void wait_for(const fs::path& file) {
    while (!fs::exists(file)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

/// The stand-in for a worker: the log's frames one by one, noting in DATA/stamps when each was durable.
int run_worker(const Options& options) {
    const SyntheticLog log = make_log(options);
    const ModelPaths paths = model_paths(options.data, options.worker_model);
    const FileHandle file = create_file(paths.live_log);
    const auto publish = [&](std::size_t n_rows) {
        replace_file(side_index_of(paths.live_log), encode_index(log_id, std::span(log.rows).first(n_rows)));
    };
    std::vector<std::int64_t> stamps;
    if (options.catch_up_mb > 0) {
        write_all(file, log.bytes);
        publish(log.rows.size());
        stamps.assign(log.rows.size(), 0);
    }
    std::ofstream(options.data / "ready").put('\n');
    wait_for(options.data / "go");
    std::uint64_t written = 0;
    const auto begun = Clock::now();
    for (std::size_t i = 0; options.catch_up_mb == 0 && i < log.rows.size(); ++i) {
        std::this_thread::sleep_until(begun + std::chrono::milliseconds(1000) * i / options.frames_per_second);
        write_all(file, std::span(log.bytes).subspan(written, log.frame_ends[i] - written));
        sync_file(file);
        written = log.frame_ends[i];
        publish(i + 1);
        stamps.push_back(Clock::now().time_since_epoch().count());
        tell(JobProgress{.stage = "refine", .fraction = 0.5, .n_vertices = log.rows[i].n_vertices, .n_bytes = written});
    }
    replace_file(options.data / "stamps", std::as_bytes(std::span(stamps)));
    if (options.n_stalled > 0) wait_for(options.data / "enough");
    tell(JobDone{});
    return 0;
}

/// A server in a process of its own.
class ServerProcess {
public:
    explicit ServerProcess(const Options& options) {
        int ends[2];
        if (::pipe(ends) != 0) throw IoError("no pipe");
        pid_ = ::fork();
        if (pid_ == 0) {
            ::close(ends[0]);
            serve(options, ends[1]);
        }
        ::close(ends[1]);
        FILE* url = ::fdopen(ends[0], "r");
        char text[100] = "";
        if (std::fscanf(url, "%99s", text) != 1) throw IoError("the server did not start");
        std::fclose(url);
        url_ = parse_url(text);
    }
    ~ServerProcess() {
        ::kill(pid_, SIGKILL);
        ::waitpid(pid_, nullptr, 0);
    }
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;

    const Url& url() const { return url_; }
    std::uint16_t port() const { return static_cast<std::uint16_t>(std::stoi(url_.port)); }
    std::uint64_t resident_bytes() const {
        std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
        std::uint64_t total = 0, resident = 0;
        statm >> total >> resident;
        return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    }

private:
    [[noreturn]] static void serve(const Options& options, int url_pipe) {
        try {
            const std::string self = fs::read_symlink("/proc/self/exe");
            const auto command = [&](const ModelRecord& model) -> std::vector<std::string> {
                return {self,
                        "--worker-model",
                        model.id,
                        "--data",
                        options.data.string(),
                        "--frame-bytes",
                        std::to_string(options.frame_bytes),
                        "--frames-per-second",
                        std::to_string(options.frames_per_second),
                        "--seconds",
                        std::to_string(options.seconds),
                        "--catch-up",
                        std::to_string(options.catch_up_mb),
                        "--stalled",
                        std::to_string(options.n_stalled)};
            };
            Server server({.port = 0,
                           .data = options.data,
                           .token = {},
                           .max_connections = 20'000,
                           .worker_command = command,
                           .log = [](const std::string& line) { std::fprintf(stderr, "server: %s\n", line.c_str()); }});
            const std::string url = server.url() + "\n";
            if (::write(url_pipe, url.data(), url.size()) < 0) std::_Exit(1);
            ::close(url_pipe);
            server.run({});
        } catch (const std::exception& error) {
            std::fprintf(stderr, "server: %s\n", error.what());
        }
        std::_Exit(1);
    }

    pid_t pid_ = -1;
    Url url_;
};

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
Json watch_stalled(const ServerProcess& server, const Options& options, LiveLoad& load) {
    std::uint64_t longest = 0;
    double evicted = 0, seconds = 0;
    std::optional<Clock::time_point> full_at;
    const auto deadline = Clock::now() + std::chrono::seconds(90);
    while (evicted < options.n_stalled && Clock::now() < deadline) {
        load.read_to_end(std::chrono::milliseconds(200));
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

Json run(Options options) {
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
        wait_for(options.data / "ready");
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
            result["stalled"] = watch_stalled(server, options, load);
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
    Options options;
    app.add_option("--clients", options.n_clients, "live clients")->capture_default_str();
    app.add_option("--stalled", options.n_stalled, "of them that take nothing")->capture_default_str();
    app.add_option("--frame-bytes", options.frame_bytes, "of each frame")->capture_default_str();
    app.add_option("--frames-per-second", options.frames_per_second, "while the model is made")->capture_default_str();
    app.add_option("--seconds", options.seconds, "that the model takes")->capture_default_str();
    app.add_option("--catch-up", options.catch_up_mb, "MB of a log that is there when the clients come");
    app.add_option("--idle", options.idle_seconds, "seconds in which nothing happens");
    app.add_option("--worker-model", options.worker_model)->group("");
    app.add_option("--data", options.data)->group("");
    // A worker's standard output is the server's.
    for (int i = 1; i < argc; ++i)
        if (std::string(argv[i]) == "--worker-model") {
            CLI11_PARSE(app, argc, argv);
            return run_worker(options);
        }
    return run_tool(app, argc, argv, [&] { return run(options); });
}
