#pragma once
#include <optional>

#include "core/reconstruction/reconstruct.h"

namespace anyrate {

/// Shows a reconstruction's progress on the standard error: one line that moves on a terminal, a plain line at every
/// new stage and quarter of a stage elsewhere (a log file keeps a handful of lines).
class ProgressBar {
public:
    ProgressBar();
    /// Leaves the cursor on a fresh line.
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    void show(const Progress& progress);

private:
    bool on_terminal_;
    bool line_is_open_ = false;
    std::optional<Stage> stage_;
    int step_ = -1;  ///< of this stage: percent on a terminal, quarters elsewhere
};

}  // namespace anyrate
