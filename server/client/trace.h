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
    /// What was noted belonged to a log that another replaces.
    void begin_anew();

    /// `{"frames": [{"sequence", "seconds", "bytes", "vertices", "distortion"}]}`: each frame that arrived whole,
    /// seconds since the trace began, `bytes` the prefix that ends with it. With `"replaced": [{"seconds", "bytes"}]`
    /// if logs were replaced: when the last bytes of each arrived, and how many it had.
    std::string to_json(std::span<const IndexRow> rows, std::uint64_t frames_begin) const;

private:
    struct Arrival {
        double seconds;
        std::uint64_t n_bytes;
    };
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
    std::vector<Arrival> arrivals_, replaced_;
};

}  // namespace anyrate
