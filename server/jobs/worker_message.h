#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "server/store/catalog.h"

namespace anyrate {

/// The attempt goes on behind so many bytes of the log; 0: the log is begun anew.
struct JobBegun {
    std::uint64_t n_bytes = 0;
    friend bool operator==(const JobBegun&, const JobBegun&) = default;
};
/// Who is to blame for a failure, and with it what follows.
enum class FailureCause {
    capture,  ///< the job cannot be done
    machine,  ///< it may be tried again
    no_room,  ///< it waits for room on the disk, however long that takes
};
struct JobFailed {
    std::string error;
    FailureCause cause = FailureCause::capture;
    friend bool operator==(const JobFailed&, const JobFailed&) = default;
};
/// The log is sealed.
struct JobDone {
    friend bool operator==(const JobDone&, const JobDone&) = default;
};
/// The worker was told to stop and did so.
struct JobStopped {
    friend bool operator==(const JobStopped&, const JobStopped&) = default;
};

/// What a worker process tells the server, one JSON object a line on its standard output.
using WorkerMessage = std::variant<JobBegun, JobProgress, RatePoint, JobFailed, JobDone, JobStopped>;

/// One line with its line feed.
std::string encode_worker_message(const WorkerMessage& message);
/// @throws DecodeError the line is no such message
WorkerMessage decode_worker_message(std::string_view line);

}  // namespace anyrate
