#include <doctest/doctest.h>

#include <limits>

#include "core/error.h"
#include "proto/index.h"

namespace anyrate {
namespace {

/// Base and three refinements, each with colours. Frames begin at byte 200.
const std::vector<IndexRow> rows = {{100, 1000, 50, 90}, {100, 1200, 50, 90}, {130, 1500, 30, 80}, {130, 1600, 30, 80},
                                    {160, 1900, 20, 70}, {160, 2000, 20, 70}, {199, 2300, 10, 60}, {199, 2400, 10, 60}};

std::size_t count(const Budget& budget) { return rows_for_budget(rows, budget, 200); }

}  // namespace

TEST_CASE("Budget: a vertex budget takes the frame it falls into, with its colours, and no more") {
    CHECK(count(VertexBudget{0}) == 2);
    CHECK(count(VertexBudget{100}) == 2);
    CHECK(count(VertexBudget{102}) == 2);  // 100 is within two vertices of it
    CHECK(count(VertexBudget{103}) == 4);
    CHECK(count(VertexBudget{130}) == 4);
    CHECK(count(VertexBudget{133}) == 6);
    CHECK(count(VertexBudget{199}) == 8);
    CHECK(count(VertexBudget{0xFFFFFFFF}) == 8);
    CHECK(prefix_end(rows, VertexBudget{130}, 200) == 1800);
}

TEST_CASE("Budget: a byte budget counts header and index, and is never less than base and colours") {
    CHECK(count(ByteBudget{0}) == 2);
    CHECK(count(ByteBudget{1400}) == 2);
    CHECK(count(ByteBudget{1699}) == 2);
    CHECK(count(ByteBudget{1700}) == 3);
    CHECK(count(ByteBudget{1800}) == 4);
    CHECK(count(ByteBudget{1'000'000}) == 8);
}

TEST_CASE("Budget: a distortion budget stops at the first frame that is good enough") {
    CHECK(count(DistortionBudget{60}) == 2);
    CHECK(count(DistortionBudget{30}) == 4);
    CHECK(count(DistortionBudget{29}) == 6);
    CHECK(count(DistortionBudget{1}) == 8);
}

TEST_CASE("Budget: frames of unknown distortion are never good enough") {
    std::vector<IndexRow> unknown = rows;
    for (IndexRow& row : unknown) row.mean_distortion = std::numeric_limits<float>::quiet_NaN();
    CHECK(rows_for_budget(unknown, DistortionBudget{1e9}, 200) == 8);
}

TEST_CASE("Budget: of no rows nothing can be had") {
    CHECK(rows_for_budget({}, VertexBudget{5}, 96) == 0);
    CHECK(prefix_end({}, VertexBudget{5}, 96) == 96);
}

TEST_CASE("Side index: decoding gives back what was encoded") {
    const SideIndex index = decode_index(encode_index(77, rows));
    CHECK(index.log_id == 77);
    CHECK(index.rows == rows);
    CHECK(decode_index(encode_index(1, {})).rows.empty());
}

TEST_CASE("Side index: every truncation, extension and flipped bit is rejected") {
    std::vector<std::byte> bytes = encode_index(77, rows);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        CHECK_THROWS_AS(decode_index(std::span(bytes).first(size)), DecodeError);
    }
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        auto damaged = bytes;
        damaged[bit / 8] ^= std::byte{1} << (bit % 8);
        CHECK_THROWS_AS(decode_index(damaged), DecodeError);
    }
    bytes.push_back({});
    CHECK_THROWS_AS(decode_index(bytes), DecodeError);
}

TEST_CASE("Index: rows that decrease are rejected") {
    CHECK_THROWS_AS(decode_index_rows(encode_index_rows(std::vector<IndexRow>{{100, 1000, 0, 0}, {97, 1100, 0, 0}})),
                    DecodeError);
    CHECK_THROWS_AS(decode_index_rows(encode_index_rows(std::vector<IndexRow>{{100, 1000, 0, 0}, {103, 900, 0, 0}})),
                    DecodeError);
    CHECK_THROWS_AS(decode_index_rows(std::vector<std::byte>(17)), DecodeError);
}

}  // namespace anyrate
