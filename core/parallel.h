#pragma once
// Parallel loops on oneTBB. Every iteration writes only what belongs to its own index, and sums are taken
// afterwards in index order, so that any number of threads gives the same bytes.
// With ANYRATE_OPENMP they are OpenMP's, for a program that is to be linked without oneTBB
// (tests/bench/pack_backend.sh); there a body must not throw, and what runs side by side here runs one after the other.
#ifndef ANYRATE_OPENMP
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_group.h>
#endif

#include <cstddef>
#include <exception>

namespace anyrate {

/// Calls body(i) for i in [0, n), in parallel, `grain` consecutive indices at a time.
template <class Body>
void parallel_for(std::size_t n, const Body& body, std::size_t grain = 64) {
#ifdef ANYRATE_OPENMP
#pragma omp parallel for schedule(dynamic) if (n > grain)
    for (std::size_t first = 0; first < n; first += grain)
        for (std::size_t i = first; i < n && i < first + grain; ++i) body(i);
#else
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
    });
#endif
}

/// Runs tasks that share nothing side by side.
template <class... Task>
void parallel_invoke(const Task&... task) {
#ifdef ANYRATE_OPENMP
    (task(), ...);
#else
    tbb::parallel_invoke(task...);
#endif
}

/// Runs `own` on the calling thread, to which what it uses may be bound (a graphics context, a callback), and beside it
/// `other`, which shares nothing with it. If one throws, the other still runs to its end, since a loop that is
/// cancelled would leave it half of its values; then the exception goes on, that of `own` before that of `other`.
template <class Other, class Own>
void run_beside(const Other& other, const Own& own) {
#ifdef ANYRATE_OPENMP
    other();
    own();
#else
    std::exception_ptr failure;
    tbb::task_group group;
    group.run([&] {
        try {
            other();
        } catch (...) {
            failure = std::current_exception();
        }
    });
    try {
        own();
    } catch (...) {
        group.wait();
        throw;
    }
    group.wait();
    if (failure) std::rethrow_exception(failure);
#endif
}

}  // namespace anyrate
