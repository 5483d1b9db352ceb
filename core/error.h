#pragma once
// The family of exceptions. A message says what, where, and what was expected.
#include <stdexcept>
#include <string>

namespace anyrate {

/// What a user gave is not what was asked for (exit code 3, HTTP 4xx).
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Bytes of a stream do not follow proto/FORMAT.md (exit code 3, HTTP 4xx).
struct DecodeError : InputError {
    using InputError::InputError;
};

/// The machine failed us: a file could not be opened or written, a connection broke (exit code 1, HTTP 5xx).
struct IoError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// There is no room left on the disk, or in its quota (HTTP 507).
struct DiskFull : IoError {
    using IoError::IoError;
};

/// A device that was to compute failed (its driver, its memory), or there is none: the work can go on without it.
struct DeviceError : IoError {
    using IoError::IoError;
};

}  // namespace anyrate
