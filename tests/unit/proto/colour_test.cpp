#include <doctest/doctest.h>

#include <cstdlib>
#include <random>

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

}  // namespace

TEST_CASE("Colours: with steps of one the code is lossless") {
    const RefinableMesh base(samples::icosphere(grid, 2), grid, {});
    const auto wished = random_colours(static_cast<std::size_t>(base.n_vertices()));
    ColourState colours({1, 1});
    colours.correct_base(
        base, [&](std::size_t v, const Rgb8& prediction) { return colours.quantise(prediction, wished[v]); });
    CHECK(std::ranges::equal(colours.colours(), wished));
}

TEST_CASE("Colours: the error is bounded by the steps, and does not grow from prediction to prediction") {
    const RefinableMesh base(samples::octahedron(grid), grid, {});
    const auto wished = random_colours(3006);
    ColourState colours({4, 6});
    colours.correct_base(
        base, [&](std::size_t v, const Rgb8& prediction) { return colours.quantise(prediction, wished[v]); });
    std::vector<EdgeEnds> ends;
    for (std::int32_t v = 6; v < 3006; ++v) ends.push_back({v - 1, v - 5});  // a chain of predictions
    colours.predict(ends);
    colours.correct(6, ends,
                    [&](std::size_t i, const Rgb8& prediction) { return colours.quantise(prediction, wished[6 + i]); });
    // Half a luma step, half a chroma step in green and a quarter each in the rest, and the shifts' roundings.
    for (std::size_t v = 0; v < wished.size(); ++v)
        REQUIRE(largest_difference(colours.colours()[v], wished[v]) <= 2 + 3 + 2);
}

TEST_CASE("Colours: where bits have a price, residuals shrink for little more error") {
    const ColourState colours({6, 10});
    const auto wished = random_colours(2000);
    const Rgb8 grey{128, 128, 128};
    const auto magnitude = [](const ColourResidual& r) {
        return std::abs(r.luma) + std::abs(r.orange) + std::abs(r.green);
    };
    int cheaper = 0;
    for (const Rgb8& colour : wished) {
        const ColourResidual nearest = colours.quantise(grey, colour), priced = colours.quantise(grey, colour, 4);
        REQUIRE(std::abs(priced.luma - nearest.luma) <= 2);
        REQUIRE(std::abs(priced.orange - nearest.orange) <= 2);
        REQUIRE(std::abs(priced.green - nearest.green) <= 2);
        cheaper += magnitude(priced) < magnitude(nearest) ? 1 : 0;
    }
    CHECK(cheaper > 400);
    CHECK(colours.quantise(grey, {132, 132, 132}, 1000) == ColourResidual{0, 0, 0});
    CHECK(colours.quantise(grey, {132, 132, 132}) == ColourResidual{1, 0, 0});
}

TEST_CASE("Colours: a base vertex is predicted from its lower-numbered neighbours, the first one as grey") {
    const RefinableMesh base(samples::octahedron(grid), grid, {});
    std::vector<Rgb8> predictions;
    ColourState colours({1, 1});
    colours.correct_base(base, [&](std::size_t v, const Rgb8& prediction) {
        predictions.push_back(prediction);
        const auto level = static_cast<std::uint8_t>(10 * v);
        return colours.quantise(prediction, {level, level, level});
    });
    // Vertices 0..5; opposite pairs are 0-3, 1-4, 2-5; all others are neighbours.
    const int expected[] = {128, 0, 5, 15, 17, 20};  // -, 0, (0+10)/2, (10+20)/2, (0+20+30)/3 = 16.7, (0+10+30+40)/4
    for (std::size_t v = 0; v < 6; ++v) CHECK(predictions[v].g == expected[v]);
}

TEST_CASE("Colours: a new vertex is predicted at the mean of its edge, halves up") {
    const RefinableMesh base(samples::octahedron(grid), grid, {});
    ColourState colours({1, 1});
    const std::vector<Rgb8> wished = {{10, 20, 255}, {11, 20, 255}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    colours.correct_base(
        base, [&](std::size_t v, const Rgb8& prediction) { return colours.quantise(prediction, wished[v]); });
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
