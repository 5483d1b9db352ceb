#include "server/jobs/sandbox.h"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <functional>
#include <new>
#include <thread>
#include <vector>

#include "core/error.h"
#include "server/jobs/worker_limits.h"
#include "server/store/file.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

/// What `act` returns in a process of its own; 99 if it throws.
int in_child(const std::function<int()>& act) {
    const pid_t child = ::fork();
    if (child == 0) {
        int result = 99;
        try {
            result = act();
        } catch (...) {
        }
        ::_exit(result);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 200 + WTERMSIG(status);
}

struct Fixture {
    TemporaryFolder folder;
    std::filesystem::path open = folder.path() / "open", readable = folder.path() / "readable",
                          closed = folder.path() / "closed";
    Fixture() {
        for (const auto& path : {open, readable, closed}) {
            std::filesystem::create_directories(path);
            std::ofstream(path / "file") << "secret";
        }
    }
    /// The errno that `act` leaves inside the sandbox; 0 if it succeeds.
    int sandboxed(const std::function<bool()>& act) {
        return in_child([&] {
            enter_sandbox({.readable = {readable}, .writable = {open}, .has_device = false});
            errno = 0;
            return act() ? 0 : errno;
        });
    }
    bool has_landlock() {
        return in_child([&] { return enter_sandbox({.readable = {}, .writable = {}, .has_device = false}); }) != 0;
    }
};

bool opens(const std::filesystem::path& file, int flags) {
    return static_cast<bool>(FileHandle(::open(file.c_str(), flags, 0600)));
}

}  // namespace

TEST_CASE("Sandbox: no sockets, no programs, no processes, no signals to others, no look into them") {
    Fixture f;
    CHECK(f.sandboxed([] { return ::socket(AF_INET, SOCK_STREAM, 0) >= 0; }) == EPERM);
    CHECK(f.sandboxed([] { return ::socket(AF_UNIX, SOCK_STREAM, 0) >= 0; }) == EPERM);
    CHECK(f.sandboxed([] { return ::execl("/bin/true", "true", nullptr) == 0; }) == EPERM);
    CHECK(f.sandboxed([] { return ::fork() >= 0; }) == EPERM);
    CHECK(f.sandboxed([] { return ::kill(::getppid(), 0) == 0; }) == EPERM);
    CHECK(f.sandboxed([] { return ::mkdir("/tmp/anyrate-no", 0700) == 0; }) == EPERM);
    CHECK(f.sandboxed([] {
        const rlimit more{.rlim_cur = RLIM_INFINITY, .rlim_max = RLIM_INFINITY};
        return ::setrlimit(RLIMIT_CORE, &more) == 0;
    }) == EPERM);
}

TEST_CASE("Sandbox: its own folder is open, the readable one readable, every other closed") {
    Fixture f;
    CHECK(f.sandboxed([&] { return opens(f.open / "new", O_WRONLY | O_CREAT); }) == 0);
    CHECK(f.sandboxed([&] { return ::rename((f.open / "file").c_str(), (f.open / "other").c_str()) == 0; }) == 0);
    CHECK(f.sandboxed([&] { return ::unlink((f.open / "other").c_str()) == 0; }) == 0);
    CHECK(f.sandboxed([&] { return opens(f.readable / "file", O_RDONLY); }) == 0);
    if (!f.has_landlock()) {
        MESSAGE("this kernel has no Landlock: the rest is skipped");
        return;
    }
    CHECK(f.sandboxed([&] { return opens(f.readable / "file", O_WRONLY); }) == EACCES);
    CHECK(f.sandboxed([&] { return opens(f.readable / "new", O_WRONLY | O_CREAT); }) == EACCES);
    CHECK(f.sandboxed([&] { return opens(f.closed / "file", O_RDONLY); }) == EACCES);
    CHECK(f.sandboxed([&] { return opens(f.open / ".." / "closed" / "file", O_RDONLY); }) == EACCES);
    CHECK(f.sandboxed([&] { return opens("/etc/passwd", O_RDONLY); }) == EACCES);
    CHECK(f.sandboxed([&] { return ::rename((f.readable / "file").c_str(), (f.open / "moved").c_str()) == 0; }) != 0);
}

TEST_CASE("Sandbox: a link out of the folder leads nowhere") {
    Fixture f;
    if (!f.has_landlock()) return;
    std::filesystem::create_symlink(f.closed / "file", f.open / "link");
    CHECK(f.sandboxed([&] { return opens(f.open / "link", O_RDONLY); }) == EACCES);
}

TEST_CASE("Sandbox: threads and memory are there") {
#ifndef ANYRATE_SANITIZED  // UBSan looks at a thread's virtual table through a pipe, which the sandbox forbids
    Fixture f;
    CHECK(f.sandboxed([&] {
        int n = 0;
        std::thread([&] { n = static_cast<int>(std::vector<char>(50'000'000, 1).size()); }).join();
        return n == 50'000'000;
    }) == 0);
#endif
}

TEST_CASE("Worker limits: memory beyond the limit is not to be had") {
#ifndef ANYRATE_SANITIZED
    const auto allocates = [](std::size_t n_bytes) {
        return in_child([=] {
            apply_worker_limits({.memory_bytes = 256u << 20});
            try {
                std::vector<char> block;
                block.resize(n_bytes, 1);
                return block.empty() || block.front() != 1 ? 2 : 0;
            } catch (const std::bad_alloc&) {
                return 1;
            }
        });
    };
    CHECK(allocates(64u << 20) == 0);
    CHECK(allocates(512u << 20) == 1);
#endif
}

TEST_CASE("Worker limits: a file beyond the limit is not written, and the worker lives to say so") {
    TemporaryFolder folder;
    const auto writes = [&](std::size_t n_bytes) {
        return in_child([&] {
            apply_worker_limits({.file_bytes = 1u << 20});
            try {
                replace_file(folder.path() / "file", std::vector<std::byte>(n_bytes));
                return 0;
            } catch (const IoError&) {
                return 1;
            }
        });
    };
    CHECK(writes(1u << 20) == 0);
    CHECK(writes((1u << 20) + 1) == 1);
}

TEST_CASE("Worker limits: so many files are open at a time, and no more") {
    CHECK(in_child([] {
              apply_worker_limits({.open_files = 20});
              int n = 0;
              while (n < 100 && ::open("/dev/null", O_RDONLY) >= 0) ++n;
              return n < 20 && errno == EMFILE ? 0 : 1;
          }) == 0);
}

TEST_CASE("Worker limits: a worker dies with its server") {
    // child: the server, which starts a worker and ends; the worker must be gone soon after.
    int pipe_ends[2];
    REQUIRE(::pipe(pipe_ends) == 0);
    const pid_t server = ::fork();
    if (server == 0) {
        const pid_t self = ::getpid();
        if (::fork() == 0) {
            ::close(pipe_ends[0]);
            apply_worker_limits({.parent = self});
            const char ready = 'r';
            if (::write(pipe_ends[1], &ready, 1) == 1) ::pause();
            ::_exit(0);
        }
        ::pause();
    }
    ::close(pipe_ends[1]);
    char byte = 0;
    REQUIRE(::read(pipe_ends[0], &byte, 1) == 1);
    ::kill(server, SIGKILL);
    ::waitpid(server, nullptr, 0);
    CHECK(::read(pipe_ends[0], &byte, 1) == 0);  // the worker's end closes when it dies, and only then
    ::close(pipe_ends[0]);
}
