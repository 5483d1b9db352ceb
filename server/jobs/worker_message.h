#pragma once
#include <string>
#include <string_view>
#include <variant>

#include "server/store/catalog.h"

namespace anyrate {

/// The job cannot be done; `retry` says that the machine failed and not the capture.
struct JobFailed {
    std::string error;
    bool retry = false;
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
using WorkerMessage = std::variant<JobProgress, RatePoint, JobFailed, JobDone, JobStopped>;

/// One line with its line feed.
std::string encode_worker_message(const WorkerMessage& message);
/// @throws DecodeError the line is no such message
WorkerMessage decode_worker_message(std::string_view line);

}  // namespace anyrate
