#include <doctest/doctest.h>

#include <cmath>
#include <iterator>

#include "core/error.h"
#include "proto/log_writer.h"
#include "tests/unit/proto/log_fixture.h"

namespace anyrate {

using testing::same_mesh;
using testing::small_log;

namespace {

constexpr SealOptions as_they_are{.splits_per_packet = 0};

std::vector<FrameInfo> frames_of_type(const LogLayout& layout, FrameType type) {
    std::vector<FrameInfo> frames;
    std::ranges::copy_if(layout.frames, std::back_inserter(frames), [&](const auto& f) { return f.type == type; });
    return frames;
}

}  // namespace

TEST_CASE("Sealing: packets left as they are are those of the live log, byte for byte, with the index in front") {
    const auto& live = small_log().live;
    const auto sealed = seal_log(live, small_log().rows, as_they_are);
    const LogLayout layout = read_layout(sealed);
    CHECK(layout.header.sealed);
    CHECK(layout.frames[0].type == FrameType::index);
    CHECK(layout.index == small_log().rows);
    CHECK(std::ranges::equal(std::span(sealed).subspan(static_cast<std::size_t>(layout.frames_begin)),
                             std::span(live).subspan(header_size)));
    CHECK(verify_log(sealed) == layout.frames.size());
}

TEST_CASE("Sealing: neighbouring packets become one, with the hashes and distortions of the last") {
    const auto& live = small_log().live;  // six batches of at most 8 splits
    const auto sealed = seal_log(live, small_log().rows, largest_packets(24));
    CHECK(verify_log(sealed) < read_layout(live).frames.size());
    CHECK(sealed.size() < seal_log(live, small_log().rows, as_they_are).size());
    const LogLayout layout = read_layout(sealed);
    const auto packets = frames_of_type(layout, FrameType::refine);
    const auto live_packets = frames_of_type(read_layout(live), FrameType::refine);
    REQUIRE(packets.size() == 2);
    CHECK(frames_of_type(layout, FrameType::colour).size() == 3);
    for (const FrameInfo& packet : packets) {
        CHECK(std::ranges::any_of(live_packets, [&](const FrameInfo& live_packet) {
            return live_packet.n_vertices_after == packet.n_vertices_after &&
                   live_packet.state_hash == packet.state_hash;
        }));
    }
    for (const IndexRow& row : layout.index) {
        CHECK(std::ranges::any_of(small_log().rows, [&](const IndexRow& known) {
            return known.n_vertices == row.n_vertices && known.mean_distortion == row.mean_distortion &&
                   known.max_distortion == row.max_distortion;
        }));
    }
}

TEST_CASE("Sealing: every budget in vertices gives the mesh, colours and hash of the live log, however it is packed") {
    const auto& live = small_log().live;
    const auto all = static_cast<std::uint32_t>(small_log().state.n_vertices());
    for (const std::uint32_t splits : {0u, 1u, 9u, 16u, 24u, 512u, 4000u}) {
        const auto sealed = seal_log(live, small_log().rows, {.splits_per_packet = splits});
        for (std::uint32_t budget = 42; budget <= all; budget += 5) {
            REQUIRE(same_mesh(decode_mesh(sealed, VertexBudget{budget}), decode_mesh(live, VertexBudget{budget})));
        }
        ModelDecoder decoder;
        decoder.feed(sealed);
        REQUIRE(decoder.state()->state_hash() == small_log().state.state_hash());
    }
}

TEST_CASE("Sealing: batches of some hundred splits become one packet") {
    const Grid grid = samples::unit_grid(12);
    const BaseMesh base = samples::icosphere(grid, 4);  // 2562 vertices, 5120 faces
    const auto sample = samples::make_log(grid, base, {.n_batches = 3, .splits_per_batch = 200});
    const auto packed = seal_log(sample.live, sample.rows, largest_packets(2048));
    CHECK(frames_of_type(read_layout(packed), FrameType::refine).size() == 1);
    CHECK_NOTHROW(verify_log(packed));
    CHECK(same_mesh(decode_mesh(packed, VertexBudget{2900}), decode_mesh(sample.live, VertexBudget{2900})));
}

TEST_CASE("Sealing: a log cut anywhere is sealed at its last whole frame") {
    const auto& live = small_log().live;
    const LogLayout layout = read_layout(live);
    for (std::size_t size = static_cast<std::size_t>(layout.frames[0].end()); size < live.size(); size += 13) {
        const auto cut = std::span(live).first(size);
        const auto sealed = seal_log(cut, small_log().rows);
        REQUIRE(verify_log(sealed) > 0);
        REQUIRE(read_layout(sealed).ended);
        REQUIRE(same_mesh(decode_mesh(sealed, VertexBudget{0xFFFFFFFF}), decode_mesh(cut, VertexBudget{0xFFFFFFFF})));
    }
}

TEST_CASE("Sealing: a refinement whose colours were lost stays, at its predicted colours") {
    const auto& live = small_log().live;
    const FrameInfo first_refine = read_layout(live).frames[2];
    REQUIRE(first_refine.type == FrameType::refine);
    const auto sealed = seal_log(std::span(live).first(static_cast<std::size_t>(first_refine.end())), small_log().rows);
    const Mesh mesh = decode_mesh(sealed, VertexBudget{0xFFFFFFFF});
    CHECK(mesh.n_vertices() == static_cast<int>(first_refine.n_vertices_after));
    CHECK(mesh.colours.size() == mesh.vertices.size());
}

TEST_CASE("Sealing: rows that are missing have unknown distortion") {
    const auto sealed = seal_log(small_log().live, std::span(small_log().rows).first(3), as_they_are);
    const auto rows = read_layout(sealed).index;
    REQUIRE(rows.size() == small_log().rows.size());
    CHECK(rows[2] == small_log().rows[2]);
    CHECK(std::isnan(rows[4].mean_distortion));
}

TEST_CASE("Sealing: the rows of the sealed form are as good as those of the live one") {
    const auto sealed = seal_log(small_log().live, small_log().rows, largest_packets(24));
    CHECK(seal_log(small_log().live, read_layout(sealed).index, largest_packets(24)) == sealed);
}

TEST_CASE("Sealing: what is no live log with a base is refused") {
    const auto& live = small_log().live;
    CHECK_THROWS_AS(seal_log({}, {}), DecodeError);
    CHECK_THROWS_AS(seal_log(std::span(live).first(150), {}), DecodeError);
    CHECK_THROWS_AS(seal_log(seal_log(live, {}), {}), DecodeError);
}

}  // namespace anyrate
