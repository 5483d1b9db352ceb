#include "server/client/trace.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace anyrate {

void ArrivalTrace::begin_request(std::string target, std::string range, std::uint64_t n_received) {
    end_requests(n_received);
    requests_.push_back({std::move(target), std::move(range), n_received, n_received});
}

void ArrivalTrace::end_requests(std::uint64_t n_received) {
    if (!requests_.empty()) requests_.back().end = n_received;
}

void ArrivalTrace::note(std::uint64_t n_bytes) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begun_;
    arrivals_.push_back({elapsed.count(), n_bytes});
}

void ArrivalTrace::begin_anew() {
    if (arrivals_.empty()) return;
    replaced_.push_back(arrivals_.back());
    arrivals_.clear();
}

std::string ArrivalTrace::to_json(std::span<const IndexRow> rows, std::uint64_t frames_begin) const {
    nlohmann::ordered_json json = {{"requests", nlohmann::ordered_json::array()},
                                   {"frames", nlohmann::ordered_json::array()}};
    for (const Request& request : requests_) {
        json["requests"].push_back(
            {{"target", request.target}, {"range", request.range}, {"bytes", request.end - request.begin}});
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::uint64_t end = frames_begin + rows[i].end;
        const auto arrival =
            std::find_if(arrivals_.begin(), arrivals_.end(), [&](const Arrival& a) { return a.n_bytes >= end; });
        if (arrival == arrivals_.end()) break;
        nlohmann::ordered_json distortion;
        if (!std::isnan(rows[i].mean_distortion)) distortion = rows[i].mean_distortion;
        json["frames"].push_back({{"sequence", i},
                                  {"seconds", arrival->seconds},
                                  {"bytes", end},
                                  {"vertices", rows[i].n_vertices},
                                  {"distortion", distortion}});
    }
    for (const Arrival& last : replaced_)
        json["replaced"].push_back({{"seconds", last.seconds}, {"bytes", last.n_bytes}});
    return json.dump(1) + "\n";
}

}  // namespace anyrate
