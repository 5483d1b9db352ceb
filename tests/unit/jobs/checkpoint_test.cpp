#include "server/jobs/checkpoint.h"

#include <doctest/doctest.h>

#include "core/error.h"

using namespace anyrate;

namespace {

Checkpoint sample() {
    Checkpoint checkpoint{.log_id = 0xFEDCBA9876543210, .start = {}};
    RefinementStart& start = checkpoint.start;
    start.grid = {.origin = Vec3(0.1, -2.5, 1e-9), .unit = 1.0 / 3, .bits = 15, .base_shift = 3};
    start.base = {.positions = {{1, 2, 3}, {-4, 5, 6}, {7, 8, 9}}, .triangles = {{0, 1, 2}, {2, 1, 0}}};
    start.gains = {{1.1, 0.9, 1.0 / 3}};
    start.shifts = {{Vec2(0.1, 0.2)}, {Vec2(-0.3, 1e-17)}};
    start.mask_growth_px = -1.0 / 3;
    start.guess_points = {{Vec3(1, 2, 3), Vec3(0, 0, 1), 0.25}};
    start.guess_reach = 0.125;
    start.fitted.vertices = {Vec3(1.0 / 3, 2, 3), Vec3(4, 5, 6), Vec3(7, 8, 1e300)};
    start.fitted.triangles = {{0, 1, 2}};
    return checkpoint;
}

}  // namespace

TEST_CASE("Checkpoint: comes back bit for bit") {
    const auto bytes = encode_checkpoint(sample());
    const Checkpoint back = decode_checkpoint(bytes);
    CHECK(encode_checkpoint(back) == bytes);
    const RefinementStart expected = sample().start;
    CHECK(back.log_id == sample().log_id);
    CHECK(back.start.grid == expected.grid);
    CHECK(back.start.base.positions == expected.base.positions);
    CHECK(back.start.base.triangles == expected.base.triangles);
    CHECK(back.start.gains == expected.gains);
    CHECK(back.start.shifts == expected.shifts);
    CHECK(back.start.mask_growth_px == expected.mask_growth_px);
    CHECK(back.start.guess_points.at(0).normal == expected.guess_points[0].normal);
    CHECK(back.start.guess_reach == expected.guess_reach);
    CHECK(back.start.fitted.vertices == expected.fitted.vertices);
    CHECK(back.start.fitted.triangles == expected.fitted.triangles);
}

TEST_CASE("Checkpoint: a mark comes back bit for bit") {
    const LogMark mark{.n_bytes = 1ull << 33, .n_rows = 12, .seconds = 0.1, .is_rejected = {0, 1, 1, 0}};
    CHECK(decode_mark(encode_mark(mark)) == mark);
    CHECK(decode_mark(encode_mark({})) == LogMark{});
}

TEST_CASE("Checkpoint: every truncation and every flipped bit is refused") {
    for (const auto& bytes : {encode_checkpoint(sample()), encode_mark({.n_bytes = 5, .is_rejected = {1, 0, 1}})}) {
        const auto decode = [&](std::span<const std::byte> damaged) {
            decode_checkpoint(damaged);
            decode_mark(damaged);  // of the two kinds the other is refused anyway
        };
        for (std::size_t n = 0; n < bytes.size(); ++n) CHECK_THROWS_AS(decode(std::span(bytes).first(n)), DecodeError);
        for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
            auto damaged = bytes;
            damaged[bit / 8] ^= std::byte{1} << (bit % 8);
            CHECK_THROWS_AS(decode(damaged), DecodeError);
        }
    }
}
