#include "server/cli/metered_sink.h"

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

BaseMesh MeteredSink::start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) {
    const Encoding encoding(clock_);
    return writer_.start(grid, rules, base);
}

void MeteredSink::base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) {
    const Encoding encoding(clock_);
    writer_.base_attributes(colours, distortion);
    note(static_cast<int>(colours.size()), distortion);
}

void MeteredSink::batch(std::span<const SplitRecord> records, const RefinableMesh& state,
                        std::span<const Rgb8> new_colours, const DistortionPoint& distortion) {
    const Encoding encoding(clock_);
    writer_.batch(records, state, new_colours, distortion);
    note(state.n_vertices(), distortion);
}

void MeteredSink::finish() {
    const Encoding encoding(clock_);
    writer_.finish();
}

void MeteredSink::note(int n_vertices, const DistortionPoint& distortion) {
    curve_.push_back({n_vertices, writer_.rows().size(), distortion, clock_.total_seconds()});
}

}  // namespace anyrate
