#include <doctest/doctest.h>

#include <set>

#include "core/progressive/state_hash.h"
#include "tests/golden/sample_models.h"

namespace anyrate {

TEST_CASE("State hash: that of a base is mixed from its positions and triangles, word by word") {
    const Grid grid = samples::unit_grid(10);
    const BaseMesh base = samples::octahedron(grid);
    std::uint32_t h = 0;
    const auto mix = [&](std::int32_t word) {
        h = static_cast<std::uint32_t>(std::uint64_t{h ^ static_cast<std::uint32_t>(word)} * 0x9E3779B1u);
        h ^= h >> 15;
    };
    for (const GridPoint& p : base.positions) mix(p.x), mix(p.y), mix(p.z);
    for (const Triangle& t : base.triangles) mix(t[0]), mix(t[1]), mix(t[2]);
    CHECK(RefinableMesh(base, grid, {}).state_hash() == h);
}

TEST_CASE("State hash: each scalar and each face of a record changes it") {
    const Grid grid = samples::unit_grid(12);
    const RefinableMesh start(samples::icosphere(grid, 1), grid, {});
    std::vector<SplitRecord> records(11, SplitRecord{.face = 20});
    for (std::size_t k = 0; k < 3; ++k) records[k].residual[k] = 2;
    for (std::size_t k = 0; k < 6; ++k) records[3 + k].update[k] = -2;
    records[10].face = 21;
    std::set<std::uint32_t> hashes = {start.state_hash()};
    for (const SplitRecord& record : records) {
        RefinableMesh mesh = start;
        mesh.apply(record);
        hashes.insert(mesh.state_hash());
    }
    CHECK(hashes.size() == records.size() + 1);
}

TEST_CASE("State hash: one differing word always shows, whatever follows") {
    for (std::uint32_t bit = 0; bit < 32; ++bit) {
        RollingHash a, b;
        a.mix(0u), b.mix(1u << bit);
        for (std::uint32_t word = 0; word < 100; ++word) a.mix(word), b.mix(word);
        CHECK(a.value() != b.value());
    }
}

}  // namespace anyrate
