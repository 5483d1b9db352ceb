#pragma once
#include <tbb/global_control.h>

#include <optional>

namespace anyrate {

/// Lets parallel loops use at most this many threads for as long as it lives; 0 is every processor.
class ThreadLimit {
public:
    explicit ThreadLimit(int n_threads);

    int n_threads() const;

private:
    std::optional<tbb::global_control> control_;
};

}  // namespace anyrate
