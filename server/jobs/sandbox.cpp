#include "server/jobs/sandbox.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "core/error.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

[[noreturn]] void fail(const std::string& what, int error) {
    throw IoError("sandbox: cannot " + what + ": " + std::strerror(error));
}

// --- Landlock, whose library call glibc 2.36 does not have

constexpr std::uint64_t reading = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t writing =
    LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_REMOVE_FILE;
/// What exists from version 1 on.
constexpr std::uint64_t first_version = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;
/// Moving files between folders (version 2) and cutting them (version 3), which Debian's headers do not name yet.
constexpr std::uint64_t refer = 1ULL << 13, cutting = 1ULL << 14;

std::uint64_t handled_by(int version) {
    return first_version | (version >= 2 ? refer : 0) | (version >= 3 ? cutting : 0);
}

void allow(const FileHandle& rules, const std::filesystem::path& path, std::uint64_t access) {
    const FileHandle place(::open(path.c_str(), O_PATH | O_CLOEXEC));
    if (!place) {
        if (errno == ENOENT) return;
        fail("open " + path.string(), errno);
    }
    struct stat status {};
    if (::fstat(place.get(), &status) == 0 && !S_ISDIR(status.st_mode)) access &= ~LANDLOCK_ACCESS_FS_READ_DIR;
    landlock_path_beneath_attr rule{};
    rule.allowed_access = access;
    rule.parent_fd = place.get();
    if (::syscall(SYS_landlock_add_rule, rules.get(), LANDLOCK_RULE_PATH_BENEATH, &rule, 0) != 0)
        fail("open " + path.string() + " to itself", errno);
}

int confine_to(const SandboxFolders& folders) {
    const auto version =
        static_cast<int>(::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION));
    if (version < 1) return 0;
    const std::uint64_t handled = handled_by(version);
    landlock_ruleset_attr attributes{};
    attributes.handled_access_fs = handled;
    const FileHandle rules(static_cast<int>(::syscall(SYS_landlock_create_ruleset, &attributes, sizeof attributes, 0)));
    if (!rules) fail("make rules for files", errno);
    for (const auto& folder : folders.readable) allow(rules, folder, reading);
    for (const auto& folder : folders.writable) allow(rules, folder, (reading | writing | cutting) & handled);
    if (::syscall(SYS_landlock_restrict_self, rules.get(), 0) != 0) fail("confine itself to its folders", errno);
    return version;
}

// --- seccomp

/// What memory, threads, files and clocks need; whatever takes a path is Landlock's to judge.
constexpr const char* allowed_calls[] = {
    // memory
    "brk", "mmap", "munmap", "mprotect", "mremap", "madvise", "mincore",
    // threads; clone is below
    "futex", "set_robust_list", "rseq", "sched_yield", "sched_getaffinity", "sched_setaffinity", "membarrier", "gettid",
    "getpid", "getppid", "exit", "exit_group", "set_tid_address", "arch_prctl", "getcpu",
    // signals to itself
    "rt_sigaction", "rt_sigprocmask", "rt_sigreturn", "rt_sigtimedwait", "sigaltstack", "tgkill", "restart_syscall",
    // files
    "open", "openat", "close", "read", "readv", "pread64", "preadv", "write", "writev", "pwrite64", "pwritev", "lseek",
    "fstat", "stat", "lstat", "newfstatat", "statx", "statfs", "fstatfs", "access", "faccessat", "faccessat2",
    "readlink", "readlinkat", "getdents64", "getcwd", "fsync", "fdatasync", "ftruncate", "fallocate", "fadvise64",
    "rename", "renameat", "renameat2", "unlink", "unlinkat", "flock", "fcntl", "poll", "ppoll", "dup", "umask",
    // the rest
    "clock_gettime", "clock_getres", "clock_nanosleep", "nanosleep", "gettimeofday", "time", "getrandom", "getrusage",
    "getuid", "geteuid", "getgid", "getegid", "uname", "sysinfo", "times", "getpriority"};

struct ReleaseFilter {
    void operator()(void* filter) const { seccomp_release(filter); }
};

void check(int result, const std::string& what) {
    if (result < 0) fail(what, -result);
}

void allow_only_harmless_calls(bool has_device) {
    const std::unique_ptr<void, ReleaseFilter> filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)));
    if (!filter) fail("make a filter of system calls", ENOMEM);
    for (const char* name : allowed_calls) {
        const int call = seccomp_syscall_resolve_name(name);
        if (call == __NR_SCMP_ERROR || call < 0) continue;  // another architecture
        check(seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 0), std::string("allow ") + name);
    }
    if (has_device) check(seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(ioctl), 0), "allow ioctl");
    // Threads, but no processes. The arguments of clone3 are out of a filter's sight: glibc then falls back to clone.
    check(seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(clone), 1,
                           SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, CLONE_THREAD)),
          "allow threads");
    check(seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0), "refuse clone3");
    // Reading limits, of itself and without setting any.
    check(seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(prlimit64), 2, SCMP_A0(SCMP_CMP_EQ, 0),
                           SCMP_A2(SCMP_CMP_EQ, 0)),
          "allow reading limits");
    // Names of threads; nothing else of prctl.
    check(seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(prctl), 1, SCMP_A0(SCMP_CMP_EQ, PR_SET_NAME)),
          "allow names of threads");
    check(seccomp_attr_set(filter.get(), SCMP_FLTATR_CTL_TSYNC, 1), "filter all threads");
    check(seccomp_load(filter.get()), "load the filter of system calls");
}

}  // namespace

int enter_sandbox(const SandboxFolders& folders) {
    if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) fail("give up new privileges", errno);
    const int version = confine_to(folders);
    allow_only_harmless_calls(folders.has_device);
    return version;
}

}  // namespace anyrate
