#include "server/jobs/time_left.h"

#include <algorithm>
#include <array>

namespace anyrate {
namespace {

struct Share {
    std::string_view stage;
    double part;  ///< of the time of a job, relative to the others
};

/// In their order, in seconds, as measured on shared/data/pot at 10,000 vertices, on two busy cores.
constexpr std::array<Share, 7> shares = {{{"load", 0.6},
                                          {"hull", 5.5},
                                          {"poisson", 0.8},
                                          {"remesh", 1.4},
                                          {"optimise", 7.6},
                                          {"refine", 7.5},
                                          {"seal", 0.2}}};
constexpr double usual_growth = 7500;  // vertices, of which the refinement's share speaks
constexpr double least_done = 0.5;     // parts: before, there is nothing to go by

double part_of(const Share& share, double growth) {
    return share.part * (share.stage == "refine" ? growth / usual_growth : 1.0);
}

}  // namespace

TimeLeft::TimeLeft(int growth) : growth_(growth) {}

void TimeLeft::reach(std::string_view stage, double fraction, double seconds) {
    double work = 0;
    for (const Share& share : shares) {
        if (share.stage == stage) {
            work += std::clamp(fraction, 0.0, 1.0) * part_of(share, growth_);
            break;
        }
        work += part_of(share, growth_);
    }
    // A worker that goes on with a log leaps from the end of its load far into the job.
    if (stage == "refine" && stage_ == "load") leapt_ = work - shares[0].part;
    if (stage != stage_) {
        stage_begun_ = seconds;
        stage_begun_at_ = fraction;
    }
    stage_ = stage;
    fraction_ = fraction;
    done_ = work;
    elapsed_ = seconds;
}

std::optional<double> TimeLeft::seconds() const {
    // The last long stage knows its own speed best.
    if (stage_ == "refine" && fraction_ - stage_begun_at_ > 0.1)
        return (elapsed_ - stage_begun_) * std::max(0.0, 1 - fraction_) / (fraction_ - stage_begun_at_);
    const double made = done_ - leapt_;
    if (made < least_done) return std::nullopt;
    double whole = 0;
    for (const Share& share : shares) whole += part_of(share, growth_);
    return elapsed_ * std::max(0.0, whole - done_) / made;
}

}  // namespace anyrate
