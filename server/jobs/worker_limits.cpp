#include "server/jobs/worker_limits.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "core/error.h"

namespace anyrate {
namespace {

#ifdef ANYRATE_SANITIZED
constexpr bool can_limit_memory = false;  // the sanitizer's shadow is terabytes of private mapping
#else
constexpr bool can_limit_memory = true;
#endif

void limit(decltype(RLIMIT_CORE) resource, rlim_t value, const char* name) {
    const rlimit both{.rlim_cur = value, .rlim_max = value};
    if (::setrlimit(resource, &both) != 0)
        throw IoError(std::string("cannot limit the worker's ") + name + ": " + std::strerror(errno));
}

void die_with(pid_t parent) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) throw IoError("the server that started this worker is gone");
}

}  // namespace

void apply_worker_limits(const WorkerLimits& limits) {
    if (limits.parent != 0) die_with(limits.parent);
    ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    limit(RLIMIT_CORE, 0, "core files");
    if (limits.memory_bytes != 0 && can_limit_memory) limit(RLIMIT_DATA, limits.memory_bytes, "memory");
    if (limits.file_bytes != 0) {
        ::signal(SIGXFSZ, SIG_IGN);  // the write fails instead, and says why
        limit(RLIMIT_FSIZE, limits.file_bytes, "files");
    }
    if (limits.open_files != 0) limit(RLIMIT_NOFILE, static_cast<rlim_t>(limits.open_files), "open files");
    if (limits.processor_time.count() != 0)
        limit(RLIMIT_CPU, static_cast<rlim_t>(limits.processor_time.count()), "processor time");
    // Below the server, whatever the server's own is.
    ::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + 5);
}

}  // namespace anyrate
