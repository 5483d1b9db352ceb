#include "server/jobs/time_left.h"

#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

using namespace anyrate;

namespace {

/// A job whose stages take `unit` times as long as usual (in seconds, as in time_left.cpp).
const std::vector<std::pair<std::string, double>> stages = {
    {"load", 0.6}, {"hull", 5.5}, {"poisson", 0.8}, {"remesh", 1.4}, {"optimise", 7.6}, {"refine", 7.5}, {"seal", 0.2}};

}  // namespace

TEST_CASE("Time left: of a job as usual it is right at every stage, whatever the machine's speed") {
    for (const double unit : {0.1, 1.0, 30.0}) {
        TimeLeft left(7500);
        CHECK_FALSE(left.seconds());
        double whole = 0, so_far = 0;
        for (const auto& [stage, seconds] : stages) whole += unit * seconds;
        for (const auto& [stage, seconds] : stages) {
            if (so_far > 0) {
                left.reach(stage, 0.5, so_far + 0.5 * unit * seconds);
                CHECK(left.seconds().value() == doctest::Approx(whole - so_far - 0.5 * unit * seconds).epsilon(0.05));
            }
            so_far += unit * seconds;
        }
        left.reach("seal", 1, so_far);
        CHECK(left.seconds().value() == doctest::Approx(0).epsilon(1e-9));
    }
}

TEST_CASE("Time left: more vertices to refine to take longer") {
    TimeLeft few(2000), many(100'000);
    few.reach("poisson", 0, 10);
    many.reach("poisson", 0, 10);
    CHECK(many.seconds().value() > 3 * few.seconds().value());
}

TEST_CASE("Time left: a worker that goes on with a log speaks of what is left of it") {
    TimeLeft left(7500);
    left.reach("load", 0, 0);
    left.reach("refine", 0.5, 0.6);
    left.reach("refine", 0.75, 0.6 + 7.5 / 4);
    CHECK(left.seconds().value() == doctest::Approx(7.5 / 4 + 0.2).epsilon(0.1));
}
