// Compiled twice: for oneTBB, and with ANYRATE_OPENMP for the program that pack_backend.sh packs.
#include "core/parallel.h"

#include <doctest/doctest.h>

#include <atomic>
#include <vector>

using namespace anyrate;

TEST_CASE("parallel_for: visits every index once, whatever the grain") {
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{64}, std::size_t{65}, std::size_t{1000}})
        for (const std::size_t grain : {std::size_t{1}, std::size_t{7}, std::size_t{64}, std::size_t{5000}}) {
            std::vector<std::atomic<int>> visits(n);
            parallel_for(
                n, [&](std::size_t i) { ++visits[i]; }, grain);
            for (const auto& count : visits) CHECK(count == 1);
        }
}

TEST_CASE("parallel_for: may be called from one of its own loops") {
    std::atomic<int> sum = 0;
    parallel_for(
        10,
        [&](std::size_t) {
            parallel_for(
                20, [&](std::size_t i) { sum += static_cast<int>(i); }, 1);
        },
        1);
    CHECK(sum == 10 * 190);
}

TEST_CASE("parallel_invoke: runs every task") {
    int a = 0, b = 0;
    parallel_invoke([&] { a = 1; }, [&] { b = 2; });
    CHECK(a + b == 3);
}
