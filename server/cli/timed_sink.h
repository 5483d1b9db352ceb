#pragma once
#include "core/progressive/model_sink.h"
#include "server/cli/stage_clock.h"

namespace anyrate {

/// Passes a model on to another sink and charges the time that takes to Activity::encode.
class TimedSink final : public ModelSink {
public:
    /// Both must outlive it.
    TimedSink(ModelSink& sink, StageClock& clock) : sink_(sink), clock_(clock) {}

    ModelSink* preview() override { return sink_.preview(); }
    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override;
    void base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) override;
    void batch(std::span<const SplitRecord> records, const RefinableMesh& state, std::span<const Rgb8> new_colours,
               const DistortionPoint& distortion) override;
    void finish() override;

private:
    ModelSink& sink_;
    StageClock& clock_;
};

}  // namespace anyrate
