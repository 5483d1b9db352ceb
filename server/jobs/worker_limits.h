#pragma once
#include <sys/types.h>

#include <chrono>
#include <cstdint>

namespace anyrate {

struct WorkerLimits {
    std::uint64_t memory_bytes = 0;          ///< of data (heap, private mappings); 0 for no limit
    std::uint64_t file_bytes = 0;            ///< of any file it writes; 0 for no limit
    int open_files = 0;                      ///< at a time; 0 for no limit
    std::chrono::seconds processor_time{0};  ///< then SIGXCPU ends it; 0 for no limit
    pid_t parent = 0;                        ///< the server: when it dies this process is killed; 0 for none
};

/// Limits this process before it touches what somebody uploaded: memory, files, no core files, no new privileges, a
/// lower priority than the server's. @throws IoError a limit could not be set, or the parent is gone already
void apply_worker_limits(const WorkerLimits& limits);

}  // namespace anyrate
