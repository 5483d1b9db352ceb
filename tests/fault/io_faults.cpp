// A library to be preloaded: makes writes to regular files fail as a broken or full disk does, while a control file
// says so. The file that ANYRATE_FAULTS names holds two 32-bit numbers, which a test may change at any time: what fails
// (a sum of Fault) and how often (of 1000). It is mapped when a process starts, so it reaches processes that may open
// no more. Sockets, pipes and counters stay as they are.
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace {

enum Fault : std::uint32_t { no_room = 1, write_error = 2, short_write = 4, sync_error = 8, rename_error = 16 };

struct Control {
    std::uint32_t faults, per_thousand;
};

const volatile Control* control() {
    static const volatile Control* const mapped = []() -> const volatile Control* {
        const char* name = std::getenv("ANYRATE_FAULTS");
        const int file = name ? ::open(name, O_RDONLY | O_CLOEXEC) : -1;
        if (file < 0) return nullptr;
        void* place = ::mmap(nullptr, sizeof(Control), PROT_READ, MAP_SHARED, file, 0);
        ::close(file);
        return place == MAP_FAILED ? nullptr : static_cast<const volatile Control*>(place);
    }
    ();
    return mapped;
}

__attribute__((constructor)) void map_control() { control(); }

bool fails(std::uint32_t fault) {
    const volatile Control* now = control();
    if (now == nullptr || (now->faults & fault) == 0) return false;
    static std::atomic<std::uint32_t> n_calls{0};
    return (n_calls.fetch_add(1) * 2654435761U >> 8) % 1000 < now->per_thousand;
}

bool is_file(int descriptor) {
    struct stat status {};
    return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

/// @return whether the write fails, with errno set; or `n` is made smaller
bool write_fails(int descriptor, std::size_t& n) {
    const bool no_space = fails(no_room), broken = fails(write_error), cut = fails(short_write);
    if (!(no_space || broken || cut) || !is_file(descriptor)) return false;
    errno = no_space ? ENOSPC : EIO;
    if (no_space || broken) return true;
    if (n > 1) n /= 2;
    return false;
}

template <class Function>
Function next(const char* name) {
    return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

int sync_as(const char* name, int descriptor) {
    if (fails(sync_error) && is_file(descriptor)) {
        errno = EIO;
        return -1;
    }
    return next<int (*)(int)>(name)(descriptor);
}

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* bytes, std::size_t n) {
    static const auto real = next<ssize_t (*)(int, const void*, std::size_t)>("write");
    return write_fails(descriptor, n) ? -1 : real(descriptor, bytes, n);
}
ssize_t pwrite(int descriptor, const void* bytes, std::size_t n, off_t offset) {
    static const auto real = next<ssize_t (*)(int, const void*, std::size_t, off_t)>("pwrite");
    return write_fails(descriptor, n) ? -1 : real(descriptor, bytes, n, offset);
}
ssize_t pwrite64(int descriptor, const void* bytes, std::size_t n, off64_t offset) {
    static const auto real = next<ssize_t (*)(int, const void*, std::size_t, off64_t)>("pwrite64");
    return write_fails(descriptor, n) ? -1 : real(descriptor, bytes, n, offset);
}
int fsync(int descriptor) { return sync_as("fsync", descriptor); }
int fdatasync(int descriptor) { return sync_as("fdatasync", descriptor); }
int rename(const char* from, const char* to) {
    static const auto real = next<int (*)(const char*, const char*)>("rename");
    if (!fails(rename_error)) return real(from, to);
    errno = EIO;
    return -1;
}
}
