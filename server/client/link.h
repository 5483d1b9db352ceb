#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace anyrate {

/// A slower line than the real one, to see how a model arrives over it.
struct LinkOptions {
    std::uint64_t bytes_per_second = 0;    ///< 0 for as fast as it goes
    std::chrono::milliseconds latency{0};  ///< one way
};

/// Holds back what a client reads, as such a line would: two latencies pass for a new connection and two between a
/// request and its answer; bytes come one behind the other at the line's rate.
class Link {
public:
    explicit Link(LinkOptions options = {}) : options_(options) {}

    bool is_slowed() const { return options_.bytes_per_second > 0 || options_.latency.count() > 0; }
    void round_trip() const;         ///< waits for one
    void take(std::size_t n_bytes);  ///< waits until the line has carried so many more bytes

private:
    LinkOptions options_;
    std::chrono::steady_clock::time_point free_at_{};  ///< when the line has carried all it was given
};

}  // namespace anyrate
