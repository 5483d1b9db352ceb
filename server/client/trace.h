#pragma once
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "proto/index.h"

namespace anyrate {

/// When bytes of a log arrived.
class ArrivalTrace {
public:
    /// The first `n_bytes` of the log are here now.
    void note(std::uint64_t n_bytes);

    /// `{"frames": [{"sequence", "seconds", "bytes", "vertices", "distortion"}]}`: each frame that arrived whole,
    /// seconds since the trace began, `bytes` the prefix that ends with it.
    std::string to_json(std::span<const IndexRow> rows, std::uint64_t frames_begin) const;

private:
    struct Arrival {
        double seconds;
        std::uint64_t n_bytes;
    };
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
    std::vector<Arrival> arrivals_;
};

}  // namespace anyrate
