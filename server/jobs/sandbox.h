#pragma once
#include <filesystem>
#include <vector>

namespace anyrate {

/// What a sandboxed process may still reach of the file system.
struct SandboxFolders {
    std::vector<std::filesystem::path> readable;  ///< with all below; one that is not there is left out
    std::vector<std::filesystem::path> writable;  ///< likewise; files may be made, changed, renamed, removed
    bool has_device =
        false;  ///< it may go on to control devices that it has opened before (ioctl), as drivers of GPUs do
};

/// Locks this process, and every thread and child it starts from now on, in for good: no new privileges, only the
/// system calls that a reconstruction makes (seccomp: no sockets, no programs, no other processes; the rest fails with
/// "operation not permitted"), and only the given folders (Landlock). Call it before the first thread starts; to
/// one that runs already, only the filter of system calls applies.
/// @return the version of the kernel's Landlock; 0 if it has none, and then every file that the user may reach is open
/// @throws IoError the kernel refuses what it has
int enter_sandbox(const SandboxFolders& folders);

}  // namespace anyrate
