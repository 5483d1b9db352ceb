#include <doctest/doctest.h>

#include <cstdlib>
#include <random>

#include "proto/colour_rounding.h"
#include "proto/colour_state.h"
#include "tests/golden/sample_models.h"

namespace anyrate {
namespace {

const Grid grid = samples::unit_grid(10);

int largest_difference(const Rgb8& a, const Rgb8& b) {
    return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

std::vector<Rgb8> random_colours(std::size_t n) {
    std::mt19937 random(5);
    const auto channel = [&] { return static_cast<std::uint8_t>(random() % 256); };
    std::vector<Rgb8> colours;
    for (std::size_t i = 0; i < n; ++i) colours.push_back({channel(), channel(), channel()});
    return colours;
}

ColourRounding to_the_nearest(const ColourSteps& steps) { return ColourRounding({.steps = steps, .bit_price = 0}); }

}  // namespace

TEST_CASE("Colours: with steps of one the code is lossless") {
    const RefinableMesh base(samples::icosphere(grid, 2), grid, {});
    const auto wished = random_colours(static_cast<std::size_t>(base.n_vertices()));
    ColourState colours({1, 1});
    const ColourRounding rounding = to_the_nearest({1, 1});
    colours.correct_base(
        base, [&](std::size_t v, const Rgb8& prediction) { return rounding.residual(prediction, wished[v]); });
    CHECK(std::ranges::equal(colours.colours(), wished));
}

TEST_CASE("Colours: the error is bounded by the steps, and does not grow from prediction to prediction") {
    const RefinableMesh base(samples::octahedron(grid), grid, {});
    const auto wished = random_colours(3006);
    ColourState colours({4, 6});
    const ColourRounding rounding = to_the_nearest({4, 6});
    colours.correct_base(
        base, [&](std::size_t v, const Rgb8& prediction) { return rounding.residual(prediction, wished[v]); });
    std::vector<EdgeEnds> ends;
    for (std::int32_t v = 6; v < 3006; ++v) ends.push_back({v - 1, v - 5});  // a chain of predictions
    colours.predict(ends);
    colours.correct(
        6, ends, [&](std::size_t i, const Rgb8& prediction) { return rounding.residual(prediction, wished[6 + i]); });
    // Half a luma step, half a chroma step in green and a quarter each in the rest, and the shifts' roundings.
    for (std::size_t v = 0; v < wished.size(); ++v)
        REQUIRE(largest_difference(colours.colours()[v], wished[v]) <= 2 + 3 + 2);
}

TEST_CASE("Colour rounding: where bits have a price, residuals shrink for little more error") {
    const ColourSteps steps{6, 10};
    const ColourRounding free = to_the_nearest(steps), dear({.steps = steps, .bit_price = 1});
    const ColourRounding dearest({.steps = steps, .bit_price = 1000});
    const Rgb8 grey{128, 128, 128};
    const auto magnitude = [](const ColourResidual& r) {
        return std::abs(r.luma) + std::abs(r.orange) + std::abs(r.green);
    };
    int cheaper = 0;
    for (const Rgb8& colour : random_colours(2000)) {
        const ColourResidual nearest = free.residual(grey, colour), priced = dear.residual(grey, colour);
        REQUIRE(std::abs(priced.luma - nearest.luma) <= 2);
        REQUIRE(std::abs(priced.orange - nearest.orange) <= 2);
        REQUIRE(std::abs(priced.green - nearest.green) <= 2);
        cheaper += magnitude(priced) < magnitude(nearest) ? 1 : 0;
    }
    CHECK(cheaper > 400);
    CHECK(dearest.residual(grey, {132, 132, 132}) == ColourResidual{0, 0, 0});
    CHECK(free.residual(grey, {132, 132, 132}) == ColourResidual{1, 0, 0});
}

TEST_CASE("Colour rounding: of two residuals with the same error the frame's more frequent one is taken") {
    ColourRounding rounding({.steps = {4, 4}, .bit_price = 0.1});
    const Rgb8 grey{128, 128, 128}, between{134, 134, 134};  // 1.5 luma steps away
    for (const std::int32_t frequent : {1, 2}) {
        std::vector<ColourResidual> frame(20, {frequent, 0, 0});
        frame.push_back({3 - frequent, 0, 0});
        rounding.learn(frame);
        CHECK(rounding.residual(grey, between) == ColourResidual{frequent, 0, 0});
    }
}

TEST_CASE("Symbol costs: an integer costs the logarithm of its rarity and its place in the table") {
    const std::vector<std::int32_t> symbols = {0, 0, 0, 0, 7, 7, -3, 2};
    const SymbolCosts costs(symbols);
    CHECK(costs.bits(0) == doctest::Approx(1 + 8.0 / 4));
    CHECK(costs.bits(7) == doctest::Approx(2 + 8.0 / 2));
    CHECK(costs.bits(-3) == doctest::Approx(3 + 8.0));
    CHECK(costs.bits(100) > costs.bits(-3));
}

TEST_CASE("Colours: a base vertex is predicted from its lower-numbered neighbours, the first one as grey") {
    const RefinableMesh base(samples::octahedron(grid), grid, {});
    std::vector<Rgb8> predictions;
    ColourState colours({1, 1});
    const ColourRounding rounding = to_the_nearest({1, 1});
    colours.correct_base(base, [&](std::size_t v, const Rgb8& prediction) {
        predictions.push_back(prediction);
        const auto level = static_cast<std::uint8_t>(10 * v);
        return rounding.residual(prediction, {level, level, level});
    });
    // Vertices 0..5; opposite pairs are 0-3, 1-4, 2-5; all others are neighbours.
    const int expected[] = {128, 0, 5, 15, 17, 20};  // -, 0, (0+10)/2, (10+20)/2, (0+20+30)/3 = 16.7, (0+10+30+40)/4
    for (std::size_t v = 0; v < 6; ++v) CHECK(predictions[v].g == expected[v]);
}

TEST_CASE("Colours: a new vertex is predicted at the mean of its edge, halves up") {
    const RefinableMesh base(samples::octahedron(grid), grid, {});
    ColourState colours({1, 1});
    const ColourRounding rounding = to_the_nearest({1, 1});
    const std::vector<Rgb8> wished = {{10, 20, 255}, {11, 20, 255}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    colours.correct_base(
        base, [&](std::size_t v, const Rgb8& prediction) { return rounding.residual(prediction, wished[v]); });
    colours.predict(std::vector<EdgeEnds>{{0, 1}});
    CHECK(colours.colours()[6] == Rgb8{11, 20, 255});
}

TEST_CASE("Colours: residuals that leave the range are clamped") {
    const RefinableMesh base(samples::octahedron(grid), grid, {});
    ColourState colours({255, 255});
    colours.correct_base(base, [](std::size_t v, const Rgb8&) { return ColourResidual{v % 2 ? 511 : -511, 0, 0}; });
    CHECK(colours.colours()[0] == Rgb8{0, 0, 0});
    CHECK(colours.colours()[1] == Rgb8{255, 255, 255});
}

}  // namespace anyrate
