#include <doctest/doctest.h>

#include <cmath>

#include "core/error.h"
#include "proto/log_writer.h"
#include "tests/unit/proto/log_fixture.h"

namespace anyrate {

using testing::same_mesh;
using testing::small_log;

TEST_CASE("Sealing: the frames are those of the live log, byte for byte, with the index in front") {
    const auto& live = small_log().live;
    const auto sealed = seal_log(live, small_log().rows);
    const LogLayout layout = read_layout(sealed);
    CHECK(layout.header.sealed);
    CHECK(layout.frames[0].type == FrameType::index);
    CHECK(layout.index == small_log().rows);
    CHECK(std::ranges::equal(std::span(sealed).subspan(static_cast<std::size_t>(layout.frames_begin)),
                             std::span(live).subspan(header_size)));
    CHECK(verify_log(sealed) == layout.frames.size());
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
    const auto sealed = seal_log(small_log().live, std::span(small_log().rows).first(3));
    const auto rows = read_layout(sealed).index;
    REQUIRE(rows.size() == small_log().rows.size());
    CHECK(rows[2] == small_log().rows[2]);
    CHECK(std::isnan(rows[3].mean_distortion));
}

TEST_CASE("Sealing: what is no live log with a base is refused") {
    const auto& live = small_log().live;
    CHECK_THROWS_AS(seal_log({}, {}), DecodeError);
    CHECK_THROWS_AS(seal_log(std::span(live).first(150), {}), DecodeError);
    CHECK_THROWS_AS(seal_log(seal_log(live, {}), {}), DecodeError);
}

}  // namespace anyrate
