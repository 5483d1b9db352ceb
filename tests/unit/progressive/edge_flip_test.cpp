#include <doctest/doctest.h>

#include <cmath>
#include <tuple>

#include "core/progressive/edge_flip.h"

namespace anyrate {
namespace {

constexpr FlipRule every_rule[] = {FlipRule::delaunay, FlipRule::crease_preserving, FlipRule::curvature_aligned};
const double pi = std::acos(-1.0);

/// The edge from (-half, 0, 0) to (half, 0, 0) with apexes at distance 1, the two faces bent by an angle, in radians.
EdgeQuad roof(double half, double bend) {
    return {.p = {-half, 0, 0},
            .q = {half, 0, 0},
            .m = {0, std::cos(bend / 2), -std::sin(bend / 2)},
            .s = {0, -std::cos(bend / 2), -std::sin(bend / 2)}};
}

/// Half the edge's length for an angle at either apex.
double half_edge(double angle) { return std::tan(angle / 2); }

/// Of the plane of roof(half, 0): lengths along the edge count `along` times as much, squared, as those across it.
CurvatureMetric metric_along_edge(double along) {
    return {.u = {0, 1, 0}, .v = {-1, 0, 0}, .xx = 1, .xy = 0, .yy = along};
}

EdgeQuad seen_from_the_other_end(const EdgeQuad& e) { return {.p = e.q, .q = e.p, .m = e.s, .s = e.m}; }

}  // namespace

TEST_CASE("Flip: in the plane all rules without a metric are Delaunay's: angles of more than 180 degrees together") {
    for (const FlipRule rule : every_rule) {
        CHECK_FALSE(wants_flip(roof(half_edge(0.49 * pi), 0), rule));
        CHECK(wants_flip(roof(half_edge(0.51 * pi), 0), rule));
        CHECK(wants_flip(roof(half_edge(0.9 * pi), 0), rule));
    }
}

TEST_CASE("Flip: a tie, the square, keeps its edge") {
    for (const FlipRule rule : every_rule) CHECK_FALSE(wants_flip(roof(1, 0), rule));
}

TEST_CASE("Flip: an edge along a crease stays by rule 2 from 14.4 degrees on, and turns by rule 1") {
    const double half = half_edge(0.6 * pi), limit = std::acos(0.96875);
    for (const double bend : {-1.01 * limit, 1.01 * limit, 2 * limit}) {
        CHECK(wants_flip(roof(half, bend), FlipRule::delaunay));
        CHECK_FALSE(wants_flip(roof(half, bend), FlipRule::crease_preserving));
    }
    for (const double bend : {-0.99 * limit, 0.0, 0.99 * limit}) {
        CHECK(wants_flip(roof(half, bend), FlipRule::crease_preserving));
    }
}

TEST_CASE("Flip: needles, of 270 degrees together, turn up to 35.7 degrees") {
    const double limit = std::acos(0.8125);
    for (const auto& [angle, bend, flips] :
         {std::tuple(0.76 * pi, 0.99 * limit, true), std::tuple(0.76 * pi, 1.01 * limit, false),
          std::tuple(0.74 * pi, 0.99 * limit, false)}) {
        CHECK(wants_flip(roof(half_edge(angle), bend), FlipRule::crease_preserving) == flips);
    }
}

TEST_CASE("Flip: a metric tells which angles count") {
    // Half the edge's length, in the metric, is that times the square root of `along`; 1 is the square.
    for (const double along : {0.25, 1.0, 2.25}) {
        const CurvatureMetric metric = metric_along_edge(along);
        const double tie = 1 / std::sqrt(along);
        CHECK_FALSE(wants_flip(roof(0.99 * tie, 0), FlipRule::curvature_aligned, &metric));
        CHECK(wants_flip(roof(1.01 * tie, 0), FlipRule::curvature_aligned, &metric));
    }
}

TEST_CASE("Flip: creases and needles are told without the metric") {
    const CurvatureMetric light = metric_along_edge(1e-3), heavy = metric_along_edge(1e3);
    const double crease = 1.01 * std::acos(0.96875);
    CHECK_FALSE(wants_flip(roof(1, crease), FlipRule::curvature_aligned, &heavy));
    CHECK(wants_flip(roof(half_edge(0.76 * pi), 0), FlipRule::curvature_aligned, &light));
}

TEST_CASE("Flip: it does not matter from which end the edge is seen") {
    for (const FlipRule rule : every_rule) {
        for (const double angle : {0.4, 0.55, 0.8}) {
            for (const double bend : {0.0, 0.2, 0.5, 1.5}) {
                const EdgeQuad quad = roof(half_edge(angle * pi), bend);
                CHECK(wants_flip(quad, rule) == wants_flip(seen_from_the_other_end(quad), rule));
            }
        }
    }
}

TEST_CASE("Flip: no rule folds the surface, whatever the angles") {
    // The quad is not convex at p: the other diagonal runs outside of it.
    const EdgeQuad arrow = {.p = {0, 0, 0}, .q = {10, 0, 0}, .m = {-1, 0.2, 0}, .s = {-1, -0.2, 0}};
    for (const FlipRule rule : every_rule) CHECK_FALSE(wants_flip(arrow, rule));
}

TEST_CASE("Flip: faces without area are nobody's crease") {
    const EdgeQuad point = {};
    for (const FlipRule rule : every_rule) CHECK_FALSE(wants_flip(point, rule));
}

}  // namespace anyrate
