#include "core/progressive/cheapest_scalar.h"

#include <doctest/doctest.h>

#include <initializer_list>

using namespace anyrate;

TEST_CASE("Cheapest scalar: where bits are nearly free it is the nearest") {
    for (std::int32_t nearest = -8; nearest <= 8; ++nearest)
        for (const bool is_new : {false, true}) {
            CHECK(cheapest_scalar(nearest + 0.3, 1.0, 1e-9, is_new) == nearest);
            CHECK(cheapest_scalar(nearest - 0.3, 1.0, 1e-9, is_new) == nearest);
        }
}

TEST_CASE("Cheapest scalar: the dearer the bits, the smaller it is, down to 0") {
    for (const bool is_new : {false, true}) {
        std::int32_t before = 9;
        for (double price = 1e-3; price < 1e3; price *= 2) {
            const std::int32_t scalar = cheapest_scalar(8.6, 1.0, price, is_new);
            CHECK(scalar <= before);
            CHECK(cheapest_scalar(-8.6, 1.0, price, is_new) == -scalar);
            before = scalar;
        }
        CHECK(before == 0);
    }
}

TEST_CASE("Cheapest scalar: an update has a wider dead zone than a residual") {
    CHECK(cheapest_scalar(0.9, 1.0, 0.45, false) == 0);
    CHECK(cheapest_scalar(0.9, 1.0, 0.45, true) == 1);
}
