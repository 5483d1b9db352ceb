#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/cli/stage_clock.h"

namespace anyrate {

/// The mesh after one batch of the log.
struct ReportPoint {
    int n_vertices = 0;
    std::uint64_t bytes = 0;  ///< of the sealed log's prefix that answers these vertices, header and index included
    double psi = 0;           ///< Eq. 10, squared 8-bit colour units
    double seconds = 0;       ///< wall time since the command began
};

/// What `anyrate reconstruct --report` tells about a run.
struct Report {
    std::string capture, method;
    std::string backend;  ///< who computed photo-consistency: "cpu", "gpu", or "gpu, then cpu"
    std::string device;   ///< of the GPU, as its driver names it; empty: none
    int n_threads = 0;
    std::optional<ReportPoint> preview;  ///< the hull, which clients of a server see first; not part of the log
    std::vector<ReportPoint> curve;      ///< the base first
    std::vector<double> iterations;  ///< Psi before each iteration of the surface flow and at its end; empty without it
    double max_distortion = 0;       ///< largest mean of one triangle of the final mesh
    std::uint64_t log_bytes = 0;
    bool stopped = false;  ///< interrupted before its last batch
};

/// The report as JSON, with the times of `clock` and the largest memory this process has had. `curve` is not empty.
std::string report_json(const Report& report, const StageClock& clock);

}  // namespace anyrate
