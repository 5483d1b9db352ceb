#pragma once
#include <array>
#include <chrono>

#include "core/reconstruction/reconstruct.h"

namespace anyrate {

/// What a reconstruction's wall time is spent on: reading the capture, the stages of the method, writing the log.
enum class Activity { load, hull, poisson, remesh, optimise, refine, encode };
inline constexpr std::size_t n_activities = 7;

Activity activity_of(Stage stage);

/// Adds up wall time by activity; one of them runs at any moment.
class StageClock {
public:
    /// Starts with Activity::load.
    StageClock();

    /// @return what ran until now, to go back to
    Activity switch_to(Activity activity);
    /// Of an activity so far, the running one included.
    double seconds(Activity activity) const;
    /// Since the clock was made.
    double total_seconds() const;

private:
    using Clock = std::chrono::steady_clock;

    Clock::time_point begin_, since_;
    Activity running_ = Activity::load;
    std::array<std::chrono::duration<double>, n_activities> spent_{};
};

}  // namespace anyrate
