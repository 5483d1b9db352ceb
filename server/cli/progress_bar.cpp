#include "server/cli/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace anyrate {
namespace {

std::string describe(const Progress& progress) {
    char text[96];
    std::snprintf(text, sizeof text, "%3d %%", static_cast<int>(100.0 * std::clamp(progress.fraction, 0.0, 1.0)));
    std::string line = text;
    if (progress.n_vertices > 0) {
        std::snprintf(text, sizeof text, "  %d vertices", progress.n_vertices);
        line += text;
    }
    if (progress.psi > 0) {
        std::snprintf(text, sizeof text, "  psi %.2f", progress.psi);
        line += text;
    }
    return line;
}

std::string bar(double fraction) {
    constexpr int width = 30;
    const int filled = static_cast<int>(width * std::clamp(fraction, 0.0, 1.0));
    std::string cells(width, '.');
    cells.replace(0, static_cast<std::size_t>(filled), static_cast<std::size_t>(filled), '#');
    return cells;
}

}  // namespace

ProgressBar::ProgressBar() : on_terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
    if (line_is_open_) std::fputc('\n', stderr);
}

void ProgressBar::show(const Progress& progress) {
    const int step = static_cast<int>(progress.fraction * (on_terminal_ ? 100 : 4));
    const bool new_stage = stage_ != progress.stage;
    if (!new_stage && step == step_) return;
    stage_ = progress.stage;
    step_ = step;

    if (!on_terminal_) {
        std::fprintf(stderr, "%-9s%s\n", stage_name(progress.stage), describe(progress).c_str());
        return;
    }
    if (new_stage && line_is_open_) std::fputc('\n', stderr);
    std::fprintf(stderr, "\r%-9s[%s] %s\033[K", stage_name(progress.stage), bar(progress.fraction).c_str(),
                 describe(progress).c_str());
    line_is_open_ = true;
}

}  // namespace anyrate
