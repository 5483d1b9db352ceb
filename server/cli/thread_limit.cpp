#include "server/cli/thread_limit.h"

#include <cstddef>

namespace anyrate {

ThreadLimit::ThreadLimit(int n_threads) {
    if (n_threads > 0) {
        control_.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(n_threads));
    }
}

int ThreadLimit::n_threads() const {
    return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace anyrate
