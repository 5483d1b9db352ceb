#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <random>

#include "core/error.h"
#include "proto/base_codec.h"
#include "proto/colour_codec.h"
#include "proto/draco_io.h"
#include "proto/refine_codec.h"
#include "tests/golden/sample_models.h"

namespace anyrate {
namespace {

/// More than any face that random_records() chooses.
constexpr std::int32_t n_faces = 1 << 22;

std::vector<SplitRecord> random_records(std::size_t n, std::uint32_t seed) {
    std::mt19937 random(seed);
    const auto up_to = [&](std::uint32_t k) {
        return static_cast<std::int32_t>(random() % (2 * k + 1)) - static_cast<std::int32_t>(k);
    };
    std::vector<SplitRecord> records(n);
    std::int32_t face = -1;
    for (SplitRecord& record : records) {
        face += 1 + static_cast<std::int32_t>(random() % 40);
        record.face = face;
        for (auto& x : record.residual) x = up_to(12);
        for (auto& x : record.update) x = up_to(2);
    }
    return records;
}

}  // namespace

TEST_CASE("Refine packet: decoding gives back the records, of one or of 2048 splits") {
    for (const std::size_t n : {1, 2, 100, 2048}) {
        const auto records = random_records(n, 3);
        CHECK(decode_refine(encode_refine(records, no_previous_face, n_faces), n, no_previous_face, n_faces) ==
              records);
    }
}

TEST_CASE("Refine packet: the gaps of a batch go on from the packet before") {
    const auto records = random_records(50, 4);
    const auto tail = std::span(records).subspan(20);
    const auto bytes = encode_refine(tail, records[19].face, n_faces);
    const auto decoded = decode_refine(bytes, 30, records[19].face, n_faces);
    CHECK(std::equal(decoded.begin(), decoded.end(), tail.begin(), tail.end()));
}

TEST_CASE("Refine packet: large symbols survive, larger ones are refused") {
    std::vector<SplitRecord> records = {{.face = (1 << 22) - 1, .residual = {1 << 20, -(1 << 20), 0}}};
    CHECK(decode_refine(encode_refine(records, -1, n_faces), 1, -1, n_faces) == records);
    records[0].residual[2] = (1 << 25) + 1;
    CHECK_THROWS_AS(encode_refine(records, -1, n_faces), InputError);
}

TEST_CASE("Refine packet: several batches, each of ascending faces, come back") {
    // The second batch splits faces that the first one has made, as far as the last of them.
    const std::vector<SplitRecord> records = {{.face = 3}, {.face = 19}, {.face = 0}, {.face = 37}, {.face = 37}};
    CHECK(decode_refine(encode_refine(records, no_previous_face, 20), 5, no_previous_face, 20) == records);
}

TEST_CASE("Refine packet: a face that is not there at its turn is refused") {
    const std::vector<SplitRecord> records = {{.face = 19}, {.face = 26}};
    CHECK_THROWS_AS(encode_refine(records, no_previous_face, 20), InputError);
    CHECK_NOTHROW(encode_refine(records, no_previous_face, 21));
    // 19 + 1 + 6 = 26 wraps to face 0 of 26; twice around there is no face.
    const auto bytes = encode_refine(records, no_previous_face, 21);
    CHECK(decode_refine(bytes, 2, no_previous_face, 20)[1].face == 0);
    CHECK_THROWS_AS(decode_refine(bytes, 2, no_previous_face, 9), DecodeError);
}

TEST_CASE("Refine packet: another number of splits, another layout, no layout are rejected") {
    const auto bytes = encode_refine(random_records(10, 5), -1, n_faces);
    CHECK_THROWS_AS(decode_refine(bytes, 9, -1, n_faces), DecodeError);
    CHECK_THROWS_AS(decode_refine(bytes, 11, -1, n_faces), DecodeError);
    CHECK_THROWS_AS(decode_colour(bytes, 10), DecodeError);
    CHECK_THROWS_AS(decode_refine(encode_colour(std::vector<ColourResidual>(10)), 10, -1, n_faces), DecodeError);
    CHECK_THROWS_AS(decode_refine({}, 10, -1, n_faces), DecodeError);
    auto longer = bytes;
    longer.push_back({});
    CHECK_THROWS_AS(decode_refine(longer, 10, -1, n_faces), DecodeError);
}

TEST_CASE("Refine packet: damage is an error or other numbers, never a crash") {
    const auto bytes = encode_refine(random_records(40, 6), -1, n_faces);
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        auto damaged = bytes;
        damaged[bit / 8] ^= std::byte{1} << (bit % 8);
        try {
            const std::size_t n = decode_refine(damaged, 40, -1, n_faces).size();
            CHECK(n == 40);
        } catch (const DecodeError&) {
        }
    }
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        CHECK_THROWS_AS(decode_refine(std::span(bytes).first(size), 40, -1, n_faces), DecodeError);
    }
}

TEST_CASE("Colour packet: decoding gives back the residuals") {
    std::vector<ColourResidual> residuals;
    for (int i = 0; i < 300; ++i) residuals.push_back({i % 7 - 3, i % 5 - 2, i % 3 - 1});
    CHECK(decode_colour(encode_colour(residuals), 300) == residuals);
    CHECK_THROWS_AS(decode_colour(encode_colour(residuals), 299), DecodeError);
    residuals[5].green = 512;
    CHECK_THROWS_AS(decode_colour(encode_colour(residuals), 300), DecodeError);
}

TEST_CASE("Base: a payload that claims many faces is refused before they are allocated") {
    const Grid grid = samples::unit_grid(12);
    const BaseMesh base = samples::octahedron(grid);
    auto bytes = encode_base(base, grid.base_shift);
    constexpr std::size_t faces_at = 13;  // behind Draco's header, the traversal and the vertices
    REQUIRE(bytes[faces_at] == std::byte{8});
    bytes[faces_at] = std::byte{0x80};
    for (const int more : {0x10, 0x80, 0x80}) bytes.insert(bytes.begin() + faces_at + 1, static_cast<std::byte>(more));
    Header header;
    header.grid = grid;
    header.n_base_vertices = 6;
    header.n_base_faces = 1u << 25;
    CHECK_THROWS_WITH_AS(decode_base(bytes, header), doctest::Contains("cannot hold"), DecodeError);
}

TEST_CASE("Draco payload: another version of the bitstream, whose counts stand elsewhere, is refused") {
    const Grid grid = samples::unit_grid(12);
    Header header;
    header.grid = grid;
    header.n_base_vertices = 6;
    header.n_base_faces = 8;
    for (const std::size_t at : {5u, 6u}) {
        auto base = encode_base(samples::octahedron(grid), grid.base_shift);
        base[at] = std::byte{1};
        CHECK_THROWS_WITH_AS(decode_base(base, header), doctest::Contains("expected version 2.2"), DecodeError);
        auto packet = encode_refine(random_records(10, 5), -1, n_faces);
        packet[at] = std::byte{1};
        CHECK_THROWS_WITH_AS(decode_refine(packet, 10, -1, n_faces), doctest::Contains("expected version 2.3"),
                             DecodeError);
    }
}

TEST_CASE("Colour packet: attributes in groups of their own are refused") {
    const std::vector<ColourResidual> residuals = {{1, -2, 3}, {0, 4, 0}};
    const std::vector<std::byte> packet = encode_colour(residuals);
    // Behind 15 bytes: number of groups; the group's number of attributes; 5 bytes of each; the kind of each; values.
    std::vector<std::byte> grouped(packet.begin(), packet.begin() + 15);
    grouped.push_back(std::byte{2});
    for (const std::ptrdiff_t attribute : {0, 1}) {
        grouped.push_back(std::byte{1});
        grouped.insert(grouped.end(), packet.begin() + 17 + 5 * attribute, packet.begin() + 22 + 5 * attribute);
        grouped.push_back(packet[static_cast<std::size_t>(27 + attribute)]);
    }
    grouped.insert(grouped.end(), packet.begin() + 29, packet.end());
    CHECK(decode_colour(packet, 2) == residuals);
    CHECK_THROWS_WITH_AS(decode_colour(grouped, 2), "Draco payload: expected one group of attributes", DecodeError);
}

TEST_CASE("Base: a payload that announces attributes beside the position is refused") {
    const BaseMesh octahedron = samples::octahedron(samples::unit_grid(10));
    std::vector<std::byte> payload = encode_draco_mesh(octahedron);
    CHECK(payload[14] == std::byte{0});  // behind the two counts of a byte each
    payload[14] = std::byte{1};
    CHECK_THROWS_WITH_AS(decode_draco_mesh(payload, 6, 8), "Draco payload: expected no attribute beside the position",
                         DecodeError);
}

TEST_CASE("Base: decoding gives the same surface, on the positions it was given") {
    const Grid grid = samples::unit_grid(12);
    const BaseMesh base = samples::icosphere(grid, 2);
    Header header;
    header.grid = grid;
    header.n_base_vertices = static_cast<std::uint32_t>(base.positions.size());
    header.n_base_faces = static_cast<std::uint32_t>(base.triangles.size());
    const auto bytes = encode_base(base, grid.base_shift);
    const BaseMesh decoded = decode_base(bytes, header);

    // Draco renumbers, so triangles are compared by the positions of their corners, from the lowest one on.
    const auto triangles = [](const BaseMesh& mesh) {
        std::vector<std::array<std::array<int, 3>, 3>> out;
        for (const Triangle& t : mesh.triangles) {
            auto& corners = out.emplace_back();
            for (std::size_t i = 0; i < 3; ++i) {
                const GridPoint& p = mesh.positions[static_cast<std::size_t>(t[i])];
                corners[i] = {p.x, p.y, p.z};
            }
            std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        }
        std::sort(out.begin(), out.end());
        return out;
    };
    CHECK(triangles(decoded) == triangles(base));

    header.n_base_faces += 2;
    CHECK_THROWS_AS(decode_base(bytes, header), DecodeError);
    header.n_base_vertices = 1 << 24;
    CHECK_THROWS_AS(decode_base(bytes, header), DecodeError);
}

TEST_CASE("Base: positions that are no multiples of the base shift are refused") {
    const Grid grid = samples::unit_grid(12);
    BaseMesh base = samples::octahedron(grid);
    base.positions[3].z += 1;
    CHECK_THROWS_AS(encode_base(base, grid.base_shift), InputError);
}

TEST_CASE("Base: damage is an error or another mesh of the same size, never a crash") {
    const Grid grid = samples::unit_grid(12);
    const BaseMesh base = samples::icosphere(grid, 1);
    const auto bytes = encode_base(base, grid.base_shift);
    Header header;
    header.grid = grid;
    header.n_base_vertices = 42;
    header.n_base_faces = 80;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        auto damaged = bytes;
        damaged[bit / 8] ^= std::byte{1} << (bit % 8);
        try {
            const BaseMesh decoded = decode_base(damaged, header);
            CHECK(decoded.positions.size() == 42);
            CHECK(decoded.triangles.size() == 80);
        } catch (const DecodeError&) {
        }
    }
}

}  // namespace anyrate
