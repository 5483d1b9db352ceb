#pragma once
#include <cstddef>
#include <vector>

#include "proto/log_writer.h"
#include "server/cli/stage_clock.h"

namespace anyrate {

/// One point of the rate-distortion curve as it came by.
struct MeteredPoint {
    int n_vertices = 0;
    std::size_t n_rows = 0;  ///< frames of the log by then
    DistortionPoint distortion;
    double seconds = 0;  ///< since the clock was made
};

/// Passes a model on to a log writer, notes the curve and charges the time to Activity::encode.
class MeteredSink final : public ModelSink {
public:
    /// Both must outlive it.
    MeteredSink(LogWriter& writer, StageClock& clock) : writer_(writer), clock_(clock) {}

    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override;
    void base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) override;
    void batch(std::span<const SplitRecord> records, const RefinableMesh& state, std::span<const Rgb8> new_colours,
               const DistortionPoint& distortion) override;
    void finish() override;

    const std::vector<MeteredPoint>& curve() const { return curve_; }

private:
    void note(int n_vertices, const DistortionPoint& distortion);

    LogWriter& writer_;
    StageClock& clock_;
    std::vector<MeteredPoint> curve_;
};

}  // namespace anyrate
