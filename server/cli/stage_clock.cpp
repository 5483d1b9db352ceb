#include "server/cli/stage_clock.h"

#include <utility>

namespace anyrate {

Activity activity_of(Stage stage) {
    switch (stage) {
        case Stage::hull:
            return Activity::hull;
        case Stage::poisson:
            return Activity::poisson;
        case Stage::remesh:
            return Activity::remesh;
        case Stage::optimise:
            return Activity::optimise;
        case Stage::refine:
            return Activity::refine;
    }
    return Activity::refine;
}

StageClock::StageClock() : begin_(Clock::now()), since_(begin_) {}

Activity StageClock::switch_to(Activity activity) {
    const auto now = Clock::now();
    spent_[static_cast<std::size_t>(running_)] += now - since_;
    since_ = now;
    return std::exchange(running_, activity);
}

double StageClock::seconds(Activity activity) const {
    auto spent = spent_[static_cast<std::size_t>(activity)];
    if (activity == running_) spent += Clock::now() - since_;
    return spent.count();
}

double StageClock::total_seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }

}  // namespace anyrate
