#pragma once
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "proto/index.h"

namespace anyrate {

/// What was asked of a server, and when bytes of a log arrived.
class ArrivalTrace {
public:
    /// A request is sent. @param range          its Range field; empty if it has none
    ///                    @param n_received     body bytes of all requests before
    void begin_request(std::string target, std::string range, std::uint64_t n_received);
    /// The last request is over. @param n_received  body bytes of all requests
    void end_requests(std::uint64_t n_received);
    /// The first `n_bytes` of the log are here now.
    void note(std::uint64_t n_bytes);
    /// What was noted belonged to a log that another replaces.
    void begin_anew();

    /// `{"requests": [{"target", "range", "bytes"}], "frames": [{"sequence", "seconds", "bytes", "vertices",
    /// "distortion"}]}`: each request with the size of its body, then each frame that arrived whole, seconds since the
    /// trace began, `bytes` the prefix that ends with it. With `"replaced": [{"seconds", "bytes"}]` if logs were
    /// replaced: when the last bytes of each arrived, and how many it had.
    std::string to_json(std::span<const IndexRow> rows, std::uint64_t frames_begin) const;

private:
    struct Request {
        std::string target, range;
        std::uint64_t begin, end;  ///< body bytes received before and after it
    };
    struct Arrival {
        double seconds;
        std::uint64_t n_bytes;
    };
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
    std::vector<Request> requests_;
    std::vector<Arrival> arrivals_, replaced_;
};

}  // namespace anyrate
