#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace anyrate {

/// How often values fell below each of some bounds. Safe to use from several threads.
class Histogram {
public:
    static constexpr std::array<double, 12> bounds = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025,
                                                      0.05,   0.1,   0.25,   1,     5,    30};  ///< seconds

    void observe(double seconds);
    /// Lines of the Prometheus text format. @param labels  `route="...",` or empty
    void write(std::string& text, const std::string& name, const std::string& labels) const;

private:
    std::array<std::atomic<std::uint64_t>, bounds.size() + 1> counts_{};
    std::atomic<std::uint64_t> total_us_ = 0;
};

/// What requests of one route did.
struct RouteMetrics {
    std::string method, pattern;
    std::array<std::atomic<std::uint64_t>, 6> by_class{};  ///< answers by the first digit of their status
    Histogram seconds;                                     ///< from the end of the header to the end of the answer
};

/// How long the stages of jobs took. Safe to use from several threads.
class StageTimes {
public:
    void add(const std::string& stage, double seconds);
    void write(std::string& text) const;  ///< lines of the Prometheus text format

private:
    struct Total {
        std::uint64_t n = 0;
        double seconds = 0;
    };
    mutable std::mutex mutex_;
    std::map<std::string, Total> totals_;
};

/// What the server counts while it runs. Safe to use from several threads.
struct Metrics {
    using Count = std::atomic<std::uint64_t>;

    std::vector<std::unique_ptr<RouteMetrics>> routes;  ///< of the router, in its order; the last for no route at all
    Count connections = 0, rejected_tokens = 0, timeouts = 0;
    Count received_bytes = 0, sent_bytes = 0;  ///< of bodies and live messages
    StageTimes stages;
    Count live_clients = 0, live_messages = 0, live_bytes = 0, live_evictions = 0, event_clients = 0;
};

/// Counts one more for as long as it lives.
class Counted {
public:
    explicit Counted(Metrics::Count& count) : count_(count) { ++count_; }
    ~Counted() { --count_; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;

private:
    Metrics::Count& count_;
};

/// One metric of the Prometheus text format without labels.
void write_metric(std::string& text, const char* name, const char* type, const char* help, double value);

/// All that `metrics` counts, in the Prometheus text format.
std::string to_prometheus(const Metrics& metrics);

}  // namespace anyrate
