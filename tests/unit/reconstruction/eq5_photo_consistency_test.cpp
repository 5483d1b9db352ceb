#include "core/reconstruction/photo_consistency.h"

#include <doctest/doctest.h>

#include <random>
#include <vector>

using namespace anyrate;

TEST_CASE("Eq. 5: F is zero where all views agree") {
    const std::vector<PointColour> colours(5, PointColour{{10, 200, 33}});
    CHECK(photo_consistency(colours) == 0.0);
}

TEST_CASE("Eq. 5: fewer than two views give no evidence") {
    CHECK(photo_consistency({}) == 0.0);
    const std::vector<PointColour> one(1, PointColour{{1, 2, 3}});
    CHECK(photo_consistency(one) == 0.0);
}

TEST_CASE("Eq. 5: two views that differ by d in one channel have the variance d^2 / 2") {
    const std::vector<PointColour> colours{{{100, 50, 7}}, {{112, 50, 7}}};
    CHECK(photo_consistency(colours) == doctest::Approx(12.0 * 12.0 / 2));
}

TEST_CASE("Eq. 5: the two-pass form equals the paper's one-pass form") {
    std::mt19937 random(7);
    std::vector<PointColour> colours(9);
    for (PointColour& c : colours)
        for (float& channel : c.c) channel = static_cast<float>(random() % 256);
    double one_pass = 0;
    const double K = 9;
    for (int k = 0; k < 3; ++k) {
        double sum = 0, squares = 0;
        for (const PointColour& c : colours) {
            sum += c.c[k];
            squares += static_cast<double>(c.c[k]) * c.c[k];
        }
        one_pass += (squares - K * (sum / K) * (sum / K)) / (K - 1);
    }
    CHECK(photo_consistency(colours) == doctest::Approx(one_pass).epsilon(1e-12));
}

TEST_CASE("Eq. 5: the estimate is unbiased: its mean over many draws is the noise's variance") {
    std::mt19937 random(11);
    std::normal_distribution<float> noise(100, 3);
    double sum = 0;
    constexpr int n_draws = 20'000;
    for (int i = 0; i < n_draws; ++i) {
        PointColour colours[4];
        for (PointColour& c : colours) c = {{noise(random), noise(random), noise(random)}};
        sum += photo_consistency(colours);
    }
    CHECK(sum / n_draws == doctest::Approx(3 * 9.0).epsilon(0.02));
}
