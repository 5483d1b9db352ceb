#include "server/jobs/worker_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <thread>
#include <utility>

#include "core/error.h"

extern char** environ;

namespace anyrate {
namespace {

constexpr std::size_t max_line = 64 * 1024;

struct Pipe {
    FileHandle reading, writing;
};

Pipe make_pipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw IoError(std::string("cannot make a pipe: ") + std::strerror(errno));
    return {FileHandle(ends[0]), FileHandle(ends[1])};
}

/// What a worker is told of the server's environment: all but the token, which it has no use for and somebody who took
/// it over had.
std::vector<char*> worker_environment() {
    std::vector<char*> variables;
    for (char** variable = environ; *variable; ++variable)
        if (!std::string_view(*variable).starts_with("ANYRATE_TOKEN")) variables.push_back(*variable);
    variables.push_back(nullptr);
    return variables;
}

pid_t spawn(const std::vector<std::string>& command, const FileHandle& standard_output) {
    std::vector<char*> arguments;
    for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, standard_output.get(), STDOUT_FILENO);
    // Sockets of clients are not the worker's business, nor would they close while it lives.
    posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
    // A group of its own: Ctrl-C on the server's terminal reaches the server, which then tells its workers.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
    sigset_t no_signals;
    sigemptyset(&no_signals);
    posix_spawnattr_setsigmask(&attributes, &no_signals);

    pid_t pid = -1;
    const std::vector<char*> environment = worker_environment();
    const int error = ::posix_spawn(&pid, arguments[0], &actions, &attributes, arguments.data(), environment.data());
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    if (error != 0) throw IoError("cannot start " + command[0] + ": " + std::strerror(error));
    return pid;
}

std::string sentence(int status) {
    if (WIFSIGNALED(status)) return "signal " + std::to_string(WTERMSIG(status));
    return "exit status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

WorkerProcess::WorkerProcess(const std::vector<std::string>& command) {
    Pipe pipe = make_pipe();
    pid_ = spawn(command, pipe.writing);
    output_ = std::move(pipe.reading);
}

WorkerProcess::~WorkerProcess() {
    if (pid_ > 0) wait(std::chrono::milliseconds(0));
}

WorkerProcess::Read WorkerProcess::read_line(std::string& line, std::chrono::milliseconds timeout) {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    for (;;) {
        if (const auto end = buffer_.find('\n'); end != std::string::npos) {
            line = buffer_.substr(0, end);
            buffer_.erase(0, end + 1);
            return Read::line;
        }
        if (buffer_.size() > max_line) return Read::end;
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
        pollfd waiting{.fd = output_.get(), .events = POLLIN, .revents = 0};
        const int ready = ::poll(&waiting, 1, static_cast<int>(std::max<std::int64_t>(0, left.count())));
        if (ready < 0 && errno == EINTR) continue;
        if (ready == 0) return Read::timeout;
        std::array<char, 4096> chunk{};
        const ssize_t got = ::read(output_.get(), chunk.data(), chunk.size());
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return Read::end;
        buffer_.append(chunk.data(), static_cast<std::size_t>(got));
    }
}

void WorkerProcess::signal(int number) const {
    if (pid_ > 0) ::kill(pid_, number);
}

std::string WorkerProcess::wait(std::chrono::milliseconds patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    int status = 0;
    while (::waitpid(pid_, &status, WNOHANG) == 0) {
        if (std::chrono::steady_clock::now() >= deadline) signal(SIGKILL);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    pid_ = -1;
    return sentence(status);
}

}  // namespace anyrate
