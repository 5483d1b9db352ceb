#include "server/cli/timed_sink.h"

namespace anyrate {
namespace {

// Charges its scope to Activity::encode.
class Encoding {
public:
    explicit Encoding(StageClock& clock) : clock_(clock), before_(clock.switch_to(Activity::encode)) {}
    ~Encoding() { clock_.switch_to(before_); }
    Encoding(const Encoding&) = delete;
    Encoding& operator=(const Encoding&) = delete;

private:
    StageClock& clock_;
    Activity before_;
};

}  // namespace

BaseMesh TimedSink::start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) {
    const Encoding encoding(clock_);
    return sink_.start(grid, rules, base);
}

void TimedSink::base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) {
    const Encoding encoding(clock_);
    sink_.base_attributes(colours, distortion);
}

void TimedSink::batch(std::span<const SplitRecord> records, const RefinableMesh& state,
                      std::span<const Rgb8> new_colours, const DistortionPoint& distortion) {
    const Encoding encoding(clock_);
    sink_.batch(records, state, new_colours, distortion);
}

void TimedSink::finish() {
    const Encoding encoding(clock_);
    sink_.finish();
}

}  // namespace anyrate
