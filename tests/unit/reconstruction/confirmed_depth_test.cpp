#include "core/reconstruction/confirmed_depth.h"

#include <doctest/doctest.h>

#include <vector>

#include "depth_scene.h"

using namespace anyrate;

namespace {

// Views straight onto one wall, one a distance.
std::vector<DepthMap> walls(std::initializer_list<double> distances) {
    std::vector<DepthMap> maps;
    for (const double distance : distances) maps.push_back(wall_at_zero(distance));
    return maps;
}

// Moves what a map sees in the middle of its picture to z = behind.
void move_middle(DepthMap& map, double distance, double behind) {
    for (int y = 12; y < 21; ++y)
        for (int x = 12; x < 21; ++x) map.inverse_depth(x, y) = static_cast<float>(1 / (distance + behind));
}

// Leaves nothing known in the middle of a map's picture, as where the surface is hidden.
void forget_middle(DepthMap& map) {
    for (int y = 12; y < 21; ++y)
        for (int x = 12; x < 21; ++x) map.inverse_depth(x, y) = 0;
}

int n_known(const DepthMap& map) {
    int n = 0;
    for (const float inverse_depth : map.inverse_depth.pixels) n += inverse_depth > 0;
    return n;
}

}  // namespace

TEST_CASE("Confirmed depth: what all views find alike is kept") {
    const auto maps = walls({4, 4.2, 4.4});
    for (const DepthMap& map : confirm_depths(maps).confirmed) CHECK(map.inverse_depth(16, 16) > 0);
}

TEST_CASE("Confirmed depth: what one view finds alone is unknown") {
    auto maps = walls({4, 4.2, 4.4, 4.6, 4.8});
    move_middle(maps[0], 4, 1);
    const auto confirmed = confirm_depths(maps).confirmed;
    CHECK(confirmed[0].inverse_depth(16, 16) == 0);
    CHECK(confirmed[1].inverse_depth(16, 16) > 0);
}

TEST_CASE("Confirmed depth: what two views find and no other looks at is kept") {
    auto maps = walls({4, 4.2, 4.4, 4.6});
    for (std::size_t i = 0; i < 2; ++i) move_middle(maps[i], 4 + 0.2 * static_cast<double>(i), 1);
    for (std::size_t i = 2; i < 4; ++i) forget_middle(maps[i]);
    const auto [found, confirmed] = confirm_depths(maps);
    CHECK(found[0].inverse_depth(16, 16) == maps[0].inverse_depth(16, 16));
    CHECK(confirmed[0].inverse_depth(16, 16) == maps[0].inverse_depth(16, 16));
}

TEST_CASE("Confirmed depth: what two views find behind the wall that a third sees is unknown") {
    auto maps = walls({4, 4.2, 4.4, 4.6});
    for (std::size_t i = 0; i < 2; ++i) move_middle(maps[i], 4 + 0.2 * static_cast<double>(i), 1);
    forget_middle(maps[3]);
    const auto [found, confirmed] = confirm_depths(maps);
    CHECK(found[0].inverse_depth(16, 16) == 0);
    CHECK(confirmed[0].inverse_depth(16, 16) == 0);
}

TEST_CASE("Confirmed depth: a place behind the wall that three views agree on falls to those that see the wall") {
    auto maps = walls({4, 4.2, 4.4, 4.6, 4.8});
    for (std::size_t i = 0; i < 3; ++i) move_middle(maps[i], 4 + 0.2 * static_cast<double>(i), 1);
    const auto [found, confirmed] = confirm_depths(maps);
    CHECK(found[0].inverse_depth(16, 16) > 0);
    CHECK(confirmed[0].inverse_depth(16, 16) == 0);
    CHECK(confirmed[0].inverse_depth(2, 16) > 0);
}

TEST_CASE("Confirmed depth: a screen in front of the wall falls to those that see through it") {
    auto maps = walls({4, 4.2, 4.4, 4.6, 4.8, 5.0, 5.2});
    for (std::size_t i = 3; i < 6; ++i) move_middle(maps[i], 4 + 0.2 * static_cast<double>(i), -1);
    CHECK(n_known(confirm_depths(maps).confirmed[3]) < n_known(maps[3]));
}

TEST_CASE("Confirmed depth: a view without a depth map is left as it is") {
    auto maps = walls({4, 4.2, 4.4});
    maps.emplace_back();
    const auto confirmed = confirm_depths(maps).confirmed;
    REQUIRE(confirmed.size() == 4);
    CHECK(confirmed[3].inverse_depth.pixels.empty());
    CHECK(confirmed[0].inverse_depth(16, 16) > 0);
}
