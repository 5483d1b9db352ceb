#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>

#include "server/store/file.h"

namespace anyrate {

/// The latest lease on something, as a number in a file. Work that is done through guarded() is done by the holder of
/// the latest lease or not at all, whichever process tries.
class LeaseFile {
public:
    /// Takes the lease. @throws LeaseLost a later one was taken already @throws IoError
    LeaseFile(const std::filesystem::path& file, std::uint64_t epoch);

    /// Does the work while no other process can take a lease or do its own. @throws LeaseLost @throws IoError somebody
    /// else's work has taken longer than 10 s; what `work` throws
    void guarded(const std::function<void()>& work) const;

private:
    FileHandle file_;
    std::uint64_t epoch_;
};

}  // namespace anyrate
