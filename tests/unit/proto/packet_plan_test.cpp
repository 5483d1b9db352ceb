#include "proto/packet_plan.h"

#include <doctest/doctest.h>

#include <limits>
#include <numeric>

namespace anyrate {

namespace {

constexpr double only_the_whole = std::numeric_limits<double>::infinity();

/// Batches that grow by a part, from so many vertices on, at 32 bytes a split and 200 of framing and tables.
std::vector<LivePacket> growing(std::uint32_t n_vertices, double growth, std::size_t n_packets) {
    std::vector<LivePacket> packets;
    for (std::size_t i = 0; i < n_packets; ++i) {
        const auto n_splits = static_cast<std::uint32_t>(growth * n_vertices / 3);
        packets.push_back({n_vertices, n_splits, 200 + 32 * n_splits, true});
        n_vertices += 3 * n_splits;
    }
    return packets;
}

std::size_t sum(const std::vector<std::size_t>& groups) {
    return std::accumulate(groups.begin(), groups.end(), std::size_t{0});
}

}  // namespace

TEST_CASE("Packet plan: no packet is lost, whatever counts") {
    const auto packets = growing(2500, 0.1, 15);
    for (const double weight : {0.0, 0.5, 10.0, only_the_whole})
        for (const std::uint32_t most : {0u, 1u, 300u, 2048u}) CHECK(sum(plan_packets(packets, most, weight)) == 15);
    CHECK(plan_packets({}, 2048, 0.5).empty());
}

TEST_CASE("Packet plan: if only the whole counts, packets are as large as they may be, the first ones first") {
    const std::vector<LivePacket> packets(7, {100, 10, 500, false});
    CHECK(plan_packets(packets, 30, only_the_whole) == std::vector<std::size_t>{3, 3, 1});
    CHECK(plan_packets(packets, 2048, only_the_whole) == std::vector<std::size_t>{7});
}

TEST_CASE("Packet plan: the more the whole counts, the fewer packets") {
    const auto packets = growing(2500, 0.1, 15);
    std::size_t n_before = packets.size() + 1;
    for (const double weight : {0.0, 1.0, 4.0, only_the_whole}) {
        const std::size_t n = plan_packets(packets, 2048, weight).size();
        CHECK(n < n_before);
        n_before = n;
    }
}

TEST_CASE("Packet plan: later packets hold more splits, for whoever gets there has loaded more") {
    const auto packets = growing(1500, 0.05, 60);
    const auto groups = plan_packets(packets, 1u << 20, 0);
    REQUIRE(groups.size() > 4);
    std::vector<std::uint32_t> n_splits;
    std::size_t i = 0;
    for (const std::size_t n : groups) {
        n_splits.push_back(0);
        for (const std::size_t end = i + n; i < end; ++i) n_splits.back() += packets[i].n_splits;
    }
    CHECK(n_splits[groups.size() - 2] > n_splits[0]);
}

TEST_CASE("Packet plan: packets with and without colours stay apart, and one beyond the limit alone") {
    std::vector<LivePacket> packets(4, {100, 10, 500, true});
    packets[2].has_colours = false;
    CHECK(plan_packets(packets, 2048, only_the_whole) == std::vector<std::size_t>{2, 1, 1});
    packets[0].n_splits = 5000;
    CHECK(plan_packets(packets, 2048, only_the_whole) == std::vector<std::size_t>{1, 1, 1, 1});
}

}  // namespace anyrate
