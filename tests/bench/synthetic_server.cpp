#include "tests/bench/synthetic_server.h"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fstream>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.h"
#include "server/http/server.h"
#include "server/jobs/worker_message.h"
#include "server/store/live_log_file.h"
#include "server/store/model_store.h"
#include "tests/bench/live_load.h"

namespace anyrate::bench {
namespace {

void tell(const WorkerMessage& message) {
    std::fputs(encode_worker_message(message).c_str(), stdout);
    std::fflush(stdout);
}

[[noreturn]] void serve(const FanOutOptions& options, int url_pipe) {
    try {
        const std::string parent = std::to_string(::getpid());
        const std::string self = std::filesystem::read_symlink("/proc/self/exe");
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
                    std::to_string(options.n_stalled),
                    "--parent",
                    parent};
        };
        ServerOptions asked;
        asked.port = 0;
        asked.data = options.data;
        asked.max_connections = 20'000;
        asked.worker_command = command;
        asked.log = [](const std::string& line) { std::fprintf(stderr, "server: %s\n", line.c_str()); };
        Server server(std::move(asked));
        const std::string url = server.url() + "\n";
        if (::write(url_pipe, url.data(), url.size()) < 0) std::_Exit(1);
        ::close(url_pipe);
        server.run({});
    } catch (const std::exception& error) {
        std::fprintf(stderr, "server: %s\n", error.what());
    }
    std::_Exit(1);
}

}  // namespace

void wait_for_file(const std::filesystem::path& file) {
    while (!std::filesystem::exists(file)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

int run_synthetic_worker(const FanOutOptions& options) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // the bench ends its server without asking
    if (::getppid() != options.parent) return 1;
    const SyntheticLog log = make_log(options);
    const ModelPaths paths = model_paths(options.data, options.worker_model);
    const FileHandle file = create_file(paths.live_log);
    const auto publish = [&](std::size_t n_rows) {
        replace_file(side_index_of(paths.live_log), encode_index(log.id, std::span(log.rows).first(n_rows)));
    };
    std::vector<std::int64_t> stamps;
    if (options.catch_up_mb > 0) {
        write_all(file, log.bytes);
        publish(log.rows.size());
        stamps.assign(log.rows.size(), 0);
    }
    std::ofstream(options.data / "ready").put('\n');
    wait_for_file(options.data / "go");
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
    if (options.n_stalled > 0) wait_for_file(options.data / "enough");
    tell(JobDone{});
    return 0;
}

ServerProcess::ServerProcess(const FanOutOptions& options) {
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

ServerProcess::~ServerProcess() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
}

std::uint64_t ServerProcess::resident_bytes() const {
    std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
    std::uint64_t total = 0, resident = 0;
    statm >> total >> resident;
    return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace anyrate::bench
