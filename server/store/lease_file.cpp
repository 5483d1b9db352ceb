#include "server/store/lease_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>

#include "proto/bytes.h"
#include "server/store/log_store.h"

namespace anyrate {
namespace {

constexpr auto patience = std::chrono::seconds(10);

/// Holds the file's lock while it lives.
class Lock {
public:
    explicit Lock(const FileHandle& file) : file_(file) {
        const auto deadline = std::chrono::steady_clock::now() + patience;
        while (::flock(file_.get(), LOCK_EX | LOCK_NB) != 0) {
            if (errno != EWOULDBLOCK && errno != EINTR)
                throw IoError(std::string("cannot lock a lease: ") + std::strerror(errno));
            if (std::chrono::steady_clock::now() > deadline)
                throw IoError("another process holds the lease's file and does not let go");
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }
    ~Lock() { ::flock(file_.get(), LOCK_UN); }
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;

private:
    const FileHandle& file_;
};

/// The number in the file; 0 in a new one.
std::uint64_t latest(const FileHandle& file) {
    const auto bytes = read_at(file, 0, sizeof(std::uint64_t));
    return bytes.size() < sizeof(std::uint64_t) ? 0 : ByteReader(bytes, "lease").take<std::uint64_t>();
}

[[noreturn]] void lost(std::uint64_t mine, std::uint64_t other) {
    throw LeaseLost("lease " + std::to_string(mine) + " is over: lease " + std::to_string(other) + " was given out");
}

}  // namespace

LeaseFile::LeaseFile(const std::filesystem::path& file, std::uint64_t epoch)
    : file_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640)), epoch_(epoch) {
    if (!file_) throw IoError("cannot open " + file.string() + ": " + std::strerror(errno));
    const Lock lock(file_);
    const std::uint64_t before = latest(file_);
    if (before > epoch_) lost(epoch_, before);
    if (before == epoch_) return;
    ByteWriter bytes;
    bytes.put(epoch_);
    write_at(file_, 0, bytes.bytes());
    sync_file(file_);
}

void LeaseFile::guarded(const std::function<void()>& work) const {
    const Lock lock(file_);
    if (const std::uint64_t now = latest(file_); now != epoch_) lost(epoch_, now);
    work();
}

}  // namespace anyrate
