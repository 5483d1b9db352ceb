// The files in tests/golden are bytes that must never change within major version 1 (see make_golden.cpp for how they
// are made).
#include <doctest/doctest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "proto/bytes.h"
#include "proto/crc32c.h"
#include "proto/log_reader.h"
#include "proto/log_writer.h"
#include "tests/golden/sample_models.h"

namespace anyrate {
namespace {

std::string read_text(const std::string& name) {
    std::ifstream file(std::string(GOLDEN_DIR) + "/" + name, std::ios::binary);
    REQUIRE_MESSAGE(file.good(), name);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::byte> read_bytes(const std::string& name) {
    const std::string text = read_text(name);
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

std::uint32_t crc_of_positions(const RefinableMesh& mesh) {
    ByteWriter out;
    for (const GridPoint& p : mesh.positions()) {
        for (const std::int32_t x : {p.x, p.y, p.z}) out.put(static_cast<std::uint32_t>(x));
    }
    return crc32c(out.bytes());
}

std::uint32_t crc_of_triangles(const RefinableMesh& mesh) {
    ByteWriter out;
    for (const Triangle& t : mesh.triangles()) {
        for (const std::int32_t v : t) out.put(static_cast<std::uint32_t>(v));
    }
    return crc32c(out.bytes());
}

std::uint32_t crc_of_colours(const Mesh& mesh) {
    ByteWriter out;
    for (const Rgb8& c : mesh.colours) {
        for (const std::uint8_t x : {c.r, c.g, c.b}) out.put(x);
    }
    return crc32c(out.bytes());
}

}  // namespace

TEST_CASE("Golden: today's reader finds in the recorded log what was recorded with it") {
    const auto log = read_bytes("icosphere.arl");
    CHECK(verify_log(log) > 40);
    const auto expectations = nlohmann::json::parse(read_text("icosphere.json"));
    REQUIRE(expectations.size() > 10);
    for (const auto& expected : expectations) {
        ModelDecoder decoder;
        decoder.set_max_vertices(expected["budget"].get<std::uint32_t>());
        decoder.feed(log);
        CHECK(decoder.state()->n_vertices() == expected["vertices"].get<int>());
        CHECK(decoder.state()->n_faces() == expected["faces"].get<int>());
        CHECK(decoder.state()->state_hash() == expected["stateHash"].get<std::uint32_t>());
        CHECK(crc_of_positions(*decoder.state()) == expected["positionsCrc"].get<std::uint32_t>());
        CHECK(crc_of_triangles(*decoder.state()) == expected["trianglesCrc"].get<std::uint32_t>());
        CHECK(crc_of_colours(decoder.mesh()) == expected["coloursCrc"].get<std::uint32_t>());
    }
}

TEST_CASE("Golden: today's writer writes the recorded bytes") {
    CHECK(samples::octahedron_log().live == read_bytes("octahedron.arl"));
    const auto sample = samples::icosphere_log();
    CHECK(seal_log(sample.live, sample.rows) == read_bytes("icosphere.arl"));
}

TEST_CASE("Golden: the worked example is what FORMAT.md says of it") {
    const auto log = read_bytes("octahedron.arl");
    const LogLayout layout = read_layout(log);
    const FrameType expected[] = {FrameType::base, FrameType::colour, FrameType::refine, FrameType::colour,
                                  FrameType::end};
    REQUIRE(layout.frames.size() == std::size(expected));
    for (std::size_t i = 0; i < layout.frames.size(); ++i) CHECK(layout.frames[i].type == expected[i]);
    const Mesh mesh = decode_mesh(log, VertexBudget{12});
    CHECK(mesh.n_vertices() == 12);
    CHECK(mesh.n_faces() == 20);
    CHECK(mesh.colours.size() == 12);
}

}  // namespace anyrate
