#include "server/client/link.h"

#include <algorithm>
#include <thread>

namespace anyrate {

void Link::round_trip() const {
    if (options_.latency.count() > 0) std::this_thread::sleep_for(2 * options_.latency);
}

void Link::take(std::size_t n_bytes) {
    if (options_.bytes_per_second == 0) return;
    const std::chrono::duration<double> on_the_line(static_cast<double>(n_bytes) /
                                                    static_cast<double>(options_.bytes_per_second));
    free_at_ = std::max(free_at_, std::chrono::steady_clock::now()) +
               std::chrono::duration_cast<std::chrono::steady_clock::duration>(on_the_line);
    std::this_thread::sleep_until(free_at_);
}

}  // namespace anyrate
