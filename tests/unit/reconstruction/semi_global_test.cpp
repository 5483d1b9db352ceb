#include "core/reconstruction/semi_global.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

using namespace anyrate;

namespace {

// A volume of the given size whose pixels have planes first .. last.
CostVolume volume_of(int width, int height, int n_planes, std::int16_t first, std::int16_t last) {
    return {n_planes, Image<std::int16_t>(width, height, first), Image<std::int16_t>(width, height, last)};
}

std::int32_t cheapest_plane(const CostVolume& volume, const std::vector<std::int16_t>& sums, int x, int y) {
    const auto& range = volume.at(x, y);
    const auto first = sums.begin() + static_cast<std::ptrdiff_t>(range.start);
    return range.first + static_cast<std::int32_t>(std::min_element(first, first + range.n) - first);
}

// Eq. 13 of Hirschmueller 2008 along a row, from either side, straight from the definition.
std::vector<std::vector<int>> path_costs(const std::vector<std::vector<int>>& costs, bool is_backward,
                                         const SemiGlobalOptions& options) {
    std::vector<std::vector<int>> path = costs;
    const int n = static_cast<int>(costs.size());
    for (int i = 1; i < n; ++i) {
        const auto x = static_cast<std::size_t>(is_backward ? n - 1 - i : i);
        const auto& before = path[is_backward ? x + 1 : x - 1];
        const int least = *std::ranges::min_element(before);
        for (std::size_t k = 0; k < costs[x].size(); ++k) {
            int cheapest = std::min(before[k], least + options.large_step);
            if (k > 0) cheapest = std::min(cheapest, before[k - 1] + options.small_step);
            if (k + 1 < before.size()) cheapest = std::min(cheapest, before[k + 1] + options.small_step);
            path[x][k] = costs[x][k] + cheapest - least;
        }
    }
    return path;
}

}  // namespace

TEST_CASE("Semi-global matching: along a row the sums are those of the definition") {
    constexpr int width = 40, n_planes = 21;
    std::mt19937 random(5);
    std::uniform_int_distribution<int> cost(0, CostVolume::worst_cost);
    CostVolume volume = volume_of(width, 1, n_planes, 0, n_planes - 1);
    std::vector<std::vector<int>> costs(width, std::vector<int>(n_planes));
    for (int x = 0; x < width; ++x)
        for (int k = 0; k < n_planes; ++k)
            volume.costs[volume.at(x, 0).start + static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(
                costs[static_cast<std::size_t>(x)][static_cast<std::size_t>(k)] = cost(random));
    const SemiGlobalOptions options;
    const std::vector<std::int16_t> sums = semi_global_sums(volume, options);
    const auto forward = path_costs(costs, false, options), backward = path_costs(costs, true, options);
    for (std::size_t x = 0; x < width; ++x)
        for (std::size_t k = 0; k < n_planes; ++k)  // the six paths from above and below have no pixel to come from
            CHECK(sums[volume.at(static_cast<int>(x), 0).start + k] ==
                  forward[x][k] + backward[x][k] + 6 * costs[x][k]);
}

TEST_CASE("Semi-global matching: a pixel that any plane would fit goes with its neighbours") {
    CostVolume volume = volume_of(9, 9, 12, 0, 11);
    for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 9; ++x)
            if (x != 4 || y != 4) volume.costs[volume.at(x, y).start + 7] = 10;
    CHECK(cheapest_plane(volume, semi_global_sums(volume), 4, 4) == 7);
}

TEST_CASE("Semi-global matching: planes outside a pixel's range are never its own, and no path goes through them") {
    constexpr int n_planes = 30;
    Image<std::int16_t> first(12, 6, 3), last(12, 6, 9);
    for (int y = 0; y < 6; ++y)
        for (int x = 6; x < 12; ++x) first(x, y) = 20, last(x, y) = 28;
    for (int y = 0; y < 6; ++y) first(2, y) = 1, last(2, y) = 0;  // no plane at all
    CostVolume volume(n_planes, first, last);
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 12; ++x)
            if (x != 2) volume.costs[volume.at(x, y).start + (x < 6 ? 4 : 5)] = 0;
    const auto sums = semi_global_sums(volume);
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 12; ++x) {
            const auto& range = volume.at(x, y);
            if (x == 2)
                CHECK(range.n == 0);
            else
                CHECK(cheapest_plane(volume, sums, x, y) == (x < 6 ? 7 : 25));
        }
}
