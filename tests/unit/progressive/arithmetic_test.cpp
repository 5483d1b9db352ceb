#include <doctest/doctest.h>

#include "core/progressive/lattice_arithmetic.h"

namespace anyrate {
namespace {

// Compiled for a processor with fused multiply-add where there is one, so that a wrong compiler flag shows here.
#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target("fma"), noinline))
#endif
double
square_minus(double x, double y) {
    return x * x - y;
}

bool can_run_fused() {
#if defined(__x86_64__) && defined(__GNUC__)
    return __builtin_cpu_supports("fma");
#else
    return true;
#endif
}

}  // namespace

TEST_CASE("Arithmetic: a product is rounded before it is added to (-ffp-contract=off)") {
    if (!can_run_fused()) {
        MESSAGE("skipped: this processor has no fused multiply-add");
        return;
    }
    const double ulp = 1.0 / (1 << 27);
    // (1 + u)^2 = 1 + 2u + u^2, and u^2 = 2^-54 is lost in a double; a fused operation would keep it.
    volatile double x = 1 + ulp, y = 1 + 2 * ulp;
    CHECK(square_minus(x, y) == 0.0);
}

TEST_CASE("Arithmetic: halves round up, also below zero") {
    CHECK(round_half_up(2.5) == 3);
    CHECK(round_half_up(-2.5) == -2);
    CHECK(round_half_up(-0.5) == 0);
    CHECK(round_half_up(1.4999) == 1);
}

TEST_CASE("Arithmetic: dot products sum x and y first") {
    // 2^53 + 1 rounds to 2^53, so the order decides whether the two ones survive.
    const double big = 9007199254740992.0;
    CHECK(dot({big, 1, 1}, {1, 1, 1}) == big);
    CHECK(dot({1, 1, big}, {1, 1, 1}) == big + 2);
}

}  // namespace anyrate
