#pragma once
// Parallel loops on oneTBB. Every iteration writes only what belongs to its own index, and sums are taken
// afterwards in index order, so that any number of threads gives the same bytes.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <cstddef>

namespace anyrate {

/// Calls body(i) for i in [0, n), in parallel, `grain` consecutive indices at a time.
template <class Body>
void parallel_for(std::size_t n, const Body& body, std::size_t grain = 64) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
    });
}

/// Runs tasks that share nothing side by side.
template <class... Task>
void parallel_invoke(const Task&... task) {
    tbb::parallel_invoke(task...);
}

}  // namespace anyrate
