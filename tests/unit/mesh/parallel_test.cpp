#include "core/parallel.h"

#include <doctest/doctest.h>

#include <stdexcept>
#include <vector>

using namespace anyrate;

namespace {

constexpr std::size_t n = 100'000;

/// Fills a vector in parallel. @return how many of its values were set
std::size_t filled() {
    std::vector<char> values(n, 0);
    parallel_for(n, [&](std::size_t i) { values[i] = 1; });
    std::size_t sum = 0;
    for (const char value : values) sum += static_cast<std::size_t>(value);
    return sum;
}

}  // namespace

TEST_CASE("Run beside: an exception of one side leaves the other its loops") {
    std::size_t n_filled = 0;
    const auto fill = [&] { n_filled = filled(); };
    CHECK_THROWS_AS(run_beside(fill, [] { throw std::runtime_error("own"); }), std::runtime_error);
    CHECK(n_filled == n);
    n_filled = 0;
    CHECK_THROWS_AS(run_beside([] { throw std::runtime_error("other"); }, fill), std::runtime_error);
    CHECK(n_filled == n);
}

TEST_CASE("Run beside: of two exceptions the one of the calling thread's side goes on") {
    CHECK_THROWS_AS(run_beside([] { throw std::runtime_error("other"); }, [] { throw std::logic_error("own"); }),
                    std::logic_error);
}
