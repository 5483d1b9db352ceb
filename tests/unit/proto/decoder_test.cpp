#include <doctest/doctest.h>

#include "core/error.h"
#include "proto/log_writer.h"
#include "tests/unit/proto/log_fixture.h"

namespace anyrate {

using testing::same_mesh;
using testing::small_log;

TEST_CASE("Decoder: the decoded state is the encoder's, bit for bit") {
    ModelDecoder decoder;
    decoder.feed(small_log().live);
    REQUIRE(decoder.state());
    CHECK(decoder.ended());
    CHECK(decoder.state()->state_hash() == small_log().state.state_hash());
    CHECK(std::ranges::equal(decoder.state()->positions(), small_log().state.positions()));
    CHECK(std::ranges::equal(decoder.state()->triangles(), small_log().state.triangles()));
    CHECK(decoder.header()->log_id == 0x0123456789ABCDEF);
}

TEST_CASE("Decoder: colours arrive within the quantiser's error") {
    const Mesh mesh = decode_mesh(small_log().live, VertexBudget{0xFFFFFFFF});
    REQUIRE(mesh.colours.size() == small_log().wished_colours.size());
    for (std::size_t v = 0; v < mesh.colours.size(); ++v) {
        REQUIRE(std::abs(mesh.colours[v].g - small_log().wished_colours[v].g) <= 7);
    }
}

TEST_CASE("Decoder: any chopping of the bytes gives the same mesh and the same last frame") {
    const std::vector<std::byte> sealed = seal_log(small_log().live, small_log().rows);
    for (const std::vector<std::byte>& log : {small_log().live, sealed}) {
        const Mesh whole = decode_mesh(log, VertexBudget{0xFFFFFFFF});
        for (const std::size_t piece : {1, 7, 95, 97, 1000}) {
            ModelDecoder decoder;
            for (std::size_t i = 0; i < log.size(); i += piece) {
                decoder.feed(std::span(log).subspan(i, std::min(piece, log.size() - i)));
            }
            CHECK(same_mesh(decoder.mesh(), whole));
            CHECK(decoder.ended());
            CHECK(decoder.last_sequence() == read_layout(log).frames.back().sequence);
        }
    }
}

TEST_CASE("Decoder: every vertex budget gives 0 to 2 vertices less, on the way the encoder went") {
    const auto& sample = small_log();
    const auto all = static_cast<std::uint32_t>(sample.state.n_vertices());
    for (std::uint32_t budget = 42; budget <= all + 5; ++budget) {
        ModelDecoder decoder;
        decoder.set_max_vertices(budget);
        decoder.feed(sample.live);
        const auto n = static_cast<std::uint32_t>(decoder.state()->n_vertices());
        REQUIRE(n <= budget);
        REQUIRE(n + 2 >= std::min(budget, all));
        REQUIRE(decoder.state()->state_hash() == sample.hash_at[(n - 42) / 3]);
        REQUIRE(same_mesh(decode_mesh(sample.live, VertexBudget{budget}), decoder.mesh()));
    }
}

TEST_CASE("Decoder: raising the budget step by step, while bytes arrive, gives the same mesh as all at once") {
    const auto& log = small_log().live;
    ModelDecoder decoder;
    std::uint32_t budget = 40;
    decoder.set_max_vertices(budget);
    for (std::size_t i = 0; i < log.size(); ++i) {
        decoder.feed(std::span(log).subspan(i, 1));
        if (i % 50 == 0) decoder.set_max_vertices(budget += 2);
    }
    CHECK(decoder.state()->n_vertices() < small_log().state.n_vertices());
    decoder.set_max_vertices(0xFFFFFFFF);
    CHECK(same_mesh(decoder.mesh(), decode_mesh(log, VertexBudget{0xFFFFFFFF})));
}

TEST_CASE("Decoder: lowering the budget takes nothing back") {
    ModelDecoder decoder;
    decoder.feed(small_log().live);
    decoder.set_max_vertices(50);
    CHECK(decoder.state()->n_vertices() == small_log().state.n_vertices());
}

TEST_CASE("Decoder: a budget's prefix is all that its mesh needs") {
    const auto& sample = small_log();
    const LogLayout layout = read_layout(sample.live);
    for (const std::uint32_t budget : {42u, 60u, 61u, 66u, 67u, 100u}) {
        const std::uint64_t end = prefix_end(layout.index, VertexBudget{budget}, layout.frames_begin);
        const auto prefix = std::span(sample.live).first(static_cast<std::size_t>(end));
        CHECK(same_mesh(decode_mesh(prefix, VertexBudget{budget}), decode_mesh(sample.live, VertexBudget{budget})));
        CHECK(verify_log(prefix) > 0);
    }
}

TEST_CASE("Decoder: without colour frames there are no colours, and the geometry is the same") {
    const Grid grid = samples::unit_grid(12);
    const auto plain =
        samples::make_log(grid, samples::icosphere(grid, 1), {.n_batches = 6, .splits_per_batch = 8, .colours = false});
    CHECK(decode_mesh(plain.live, VertexBudget{0xFFFFFFFF}).colours.empty());
    CHECK(plain.state.state_hash() == small_log().state.state_hash());
}

TEST_CASE("Decoder: before the base there is no mesh") {
    ModelDecoder decoder;
    CHECK_FALSE(decoder.header());
    decoder.feed(std::span(small_log().live).first(100));
    CHECK(decoder.header());
    CHECK_FALSE(decoder.state());
    CHECK_FALSE(decoder.last_sequence());
    CHECK_THROWS_AS(decoder.mesh(), DecodeError);
}

TEST_CASE("Decoder: an error stays, and the mesh before it too") {
    auto log = small_log().live;
    const LogLayout layout = read_layout(log);
    const FrameInfo& third = layout.frames[2];
    log[static_cast<std::size_t>(third.begin) + frame_header_size] ^= std::byte{1};
    ModelDecoder decoder;
    CHECK_THROWS_AS(decoder.feed(log), DecodeError);
    CHECK(decoder.state()->n_vertices() == 42);
    CHECK_THROWS_AS(decoder.feed({}), DecodeError);
    CHECK_THROWS_AS(decoder.set_max_vertices(100), DecodeError);
}

TEST_CASE("Layout: it tells every frame's place without decoding") {
    const LogLayout layout = read_layout(small_log().live);
    CHECK(layout.frames.size() == 2 * 7 + 1);
    CHECK(layout.ended);
    CHECK(layout.whole_bytes == small_log().live.size());
    CHECK(layout.frames_begin == header_size);
    REQUIRE(layout.index.size() == small_log().rows.size());
    for (std::size_t i = 0; i < layout.index.size(); ++i) {
        CHECK(layout.index[i].n_vertices == small_log().rows[i].n_vertices);
        CHECK(layout.index[i].end == small_log().rows[i].end);
    }
}

}  // namespace anyrate
