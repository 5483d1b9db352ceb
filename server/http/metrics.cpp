#include "server/http/metrics.h"

#include <cstdio>

namespace anyrate {
namespace {

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}

std::string shortest(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

void write_head(std::string& text, const char* name, const char* type, const char* help) {
    text += std::string("# HELP ") + name + " " + help + "\n# TYPE " + name + " " + type + "\n";
}

std::string labels_of(const RouteMetrics& route) {
    return "method=\"" + route.method + "\",route=\"" + route.pattern + "\"";
}

bool was_asked(const RouteMetrics& route) {
    for (const auto& count : route.by_class)
        if (count > 0) return true;
    return false;
}

void write_requests(std::string& text, const Metrics& metrics) {
    write_head(text, "anyrate_requests_total", "counter", "Requests by route and class of status.");
    for (const auto& route : metrics.routes)
        for (std::size_t i = 1; i < route->by_class.size(); ++i)
            if (const std::uint64_t n = route->by_class[i])
                text += "anyrate_requests_total{" + labels_of(*route) + ",status=\"" + std::to_string(i) + "xx\"} " +
                        std::to_string(n) + "\n";
    write_head(text, "anyrate_request_seconds", "histogram",
               "From the end of a request's header to that of its answer.");
    for (const auto& route : metrics.routes)
        if (was_asked(*route)) route->seconds.write(text, "anyrate_request_seconds", labels_of(*route));
}

}  // namespace

void Histogram::observe(double seconds) {
    std::size_t i = 0;
    while (i < bounds.size() && seconds > bounds[i]) ++i;
    counts_[i].fetch_add(1, std::memory_order_relaxed);
    total_us_.fetch_add(static_cast<std::uint64_t>(seconds * 1e6), std::memory_order_relaxed);
}

void Histogram::write(std::string& text, const std::string& name, const std::string& labels) const {
    const std::string separator = labels.empty() ? "" : ",";
    std::uint64_t n = 0;
    for (std::size_t i = 0; i <= bounds.size(); ++i) {
        n += counts_[i];
        const std::string bound = i < bounds.size() ? shortest(bounds[i]) : "+Inf";
        text += name + "_bucket{" + labels + separator + "le=\"" + bound + "\"} " + std::to_string(n) + "\n";
    }
    const std::string braces = labels.empty() ? "" : "{" + labels + "}";
    text += name + "_sum" + braces + " " + number(static_cast<double>(total_us_) * 1e-6) + "\n";
    text += name + "_count" + braces + " " + std::to_string(n) + "\n";
}

void StageTimes::add(const std::string& stage, double seconds) {
    const std::lock_guard lock(mutex_);
    Total& total = totals_[stage];
    ++total.n;
    total.seconds += seconds;
}

void StageTimes::write(std::string& text) const {
    const std::lock_guard lock(mutex_);
    if (totals_.empty()) return;
    write_head(text, "anyrate_stage_seconds", "summary", "Time that the stages of jobs took.");
    for (const auto& [stage, total] : totals_) {
        text += "anyrate_stage_seconds_sum{stage=\"" + stage + "\"} " + number(total.seconds) + "\n";
        text += "anyrate_stage_seconds_count{stage=\"" + stage + "\"} " + std::to_string(total.n) + "\n";
    }
}

void write_metric(std::string& text, const char* name, const char* type, const char* help, double value) {
    write_head(text, name, type, help);
    text += std::string(name) + " " + number(value) + "\n";
}

std::string to_prometheus(const Metrics& metrics) {
    std::string text;
    write_requests(text, metrics);
    const auto counter = [&](const char* name, const char* help, const Metrics::Count& count) {
        write_metric(text, name, "counter", help, static_cast<double>(count.load()));
    };
    const auto gauge = [&](const char* name, const char* help, const Metrics::Count& count) {
        write_metric(text, name, "gauge", help, static_cast<double>(count.load()));
    };
    gauge("anyrate_connections", "Open connections.", metrics.connections);
    gauge("anyrate_live_clients", "Open live WebSockets.", metrics.live_clients);
    gauge("anyrate_event_clients", "Open streams of server-sent events.", metrics.event_clients);
    counter("anyrate_live_messages_total", "Messages sent to live clients.", metrics.live_messages);
    counter("anyrate_live_bytes_total", "Bytes of these messages.", metrics.live_bytes);
    counter("anyrate_live_evictions_total", "Live clients dropped because they took nothing.", metrics.live_evictions);
    counter("anyrate_timeouts_total", "Connections dropped because a deadline passed.", metrics.timeouts);
    counter("anyrate_rejected_tokens_total", "Requests refused for want of a token.", metrics.rejected_tokens);
    counter("anyrate_received_bytes_total", "Bytes of request bodies.", metrics.received_bytes);
    counter("anyrate_sent_bytes_total", "Bytes of response bodies and live messages.", metrics.sent_bytes);
    metrics.stages.write(text);
    return text;
}

}  // namespace anyrate
