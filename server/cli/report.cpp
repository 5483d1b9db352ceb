#include "server/cli/report.h"

#include <sys/resource.h>

#include <nlohmann/json.hpp>

namespace anyrate {
namespace {

using Json = nlohmann::ordered_json;

std::uint64_t peak_memory_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

Json seconds_json(const StageClock& clock) {
    return {{"total", clock.total_seconds()},
            {"hull", clock.seconds(Activity::hull)},
            {"poisson", clock.seconds(Activity::poisson)},
            {"remesh", clock.seconds(Activity::remesh)},
            {"optimise", clock.seconds(Activity::optimise)},
            {"refine", clock.seconds(Activity::refine)},
            {"encode", clock.seconds(Activity::encode)}};
}

}  // namespace

std::string report_json(const Report& report, const StageClock& clock) {
    Json curve = Json::array();
    for (const ReportPoint& p : report.curve) {
        curve.push_back({{"vertices", p.n_vertices}, {"bytes", p.bytes}, {"psi", p.psi}, {"seconds", p.seconds}});
    }
    Json json = {{"capture", report.capture},
                 {"method", report.method},
                 {"backend", report.backend},
                 {"threads", report.n_threads},
                 {"seconds", seconds_json(clock)},
                 {"peak_memory_bytes", peak_memory_bytes()},
                 {"curve", std::move(curve)},
                 {"final",
                  {{"vertices", report.curve.back().n_vertices},
                   {"bytes", report.log_bytes},
                   {"psi", report.curve.back().psi},
                   {"max_distortion", report.max_distortion},
                   {"stopped", report.stopped}}}};
    if (!report.device.empty()) json["device"] = report.device;
    if (report.preview)
        json["preview"] = {{"vertices", report.preview->n_vertices},
                           {"bytes", report.preview->bytes},
                           {"seconds", report.preview->seconds}};
    if (!report.iterations.empty()) json["iterations"] = report.iterations;
    return json.dump(2) + "\n";
}

}  // namespace anyrate
