#include <doctest/doctest.h>

#include <cmath>

#include "core/progressive/step_rule.h"

namespace anyrate {

TEST_CASE("Step: powers of two change over at sqrt(2) between them") {
    // Right triangle with legs a: squared edges a^2, a^2, 2a^2, so the mean square is 4/3 a^2.
    const auto step = [](std::int32_t a, int ratio) { return scalar_step({0, 0, 0}, {a, 0, 0}, {0, a, 0}, ratio); };
    CHECK(step(0, 1) == 1);  // sum 0
    CHECK(step(1, 1) == 1);  // sum 4 < 6
    CHECK(step(2, 1) == 2);  // 6 <= 16 < 24
    CHECK(step(3, 1) == 4);  // 24 <= 36 < 96
    CHECK(step(4, 1) == 4);  // 64
    CHECK(step(5, 1) == 8);  // 96 <= 100
    CHECK(step(5, 5) == 1);  // 100 < 150
    CHECK(step(7, 5) == 2);  // 150 <= 196
}

TEST_CASE("Step: it is within a factor sqrt(2) of edge / ratio for all sizes") {
    for (std::int32_t a = 100; a < (1 << 20); a = a * 5 / 4) {
        const double edge = a * std::sqrt(4.0 / 3);
        const double step = scalar_step({0, 0, 0}, {a, 0, 0}, {0, a, 0}, 80);
        if (edge / 80 < 1) {
            CHECK(step <= 1 * std::sqrt(2.0));
        } else {
            CHECK(std::fabs(std::log2(step / (edge / 80))) <= 0.5 + 1e-12);
        }
    }
}

TEST_CASE("Step: the largest triangle of the finest grid and the largest ratio do not overflow") {
    const std::int32_t far = (1 << 20) - 1;
    CHECK(scalar_step({0, 0, 0}, {far, far, 0}, {0, far, far}, 1) == 1 << 20);
    CHECK(scalar_step({0, 0, 0}, {far, far, 0}, {0, far, far}, 65535) == 32);
}

}  // namespace anyrate
