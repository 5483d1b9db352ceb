// The files in tests/golden are bytes that must never change within major version 1 (see make_golden.cpp for how they
// are made).
#include <doctest/doctest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
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

RefinableMesh state_at(std::span<const std::byte> log, std::uint32_t budget) {
    ModelDecoder decoder;
    decoder.set_max_vertices(budget);
    decoder.feed(log);
    return *decoder.state();
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

void check_expectations(std::span<const std::byte> log, const nlohmann::json& expectations) {
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

}  // namespace

TEST_CASE("Golden: today's reader finds in the recorded logs what was recorded with them") {
    const auto expectations = nlohmann::json::parse(read_text("icosphere.json"));
    REQUIRE(expectations.size() > 10);
    for (const char* name : {"icosphere.arl", "icosphere-packed.arl"})
        check_expectations(read_bytes(name), expectations);
}

TEST_CASE("Golden: later rules, recorded on a cube and a sphere, are those of tomorrow") {
    for (const auto& [name, flip_rule] :
         {std::pair("cube", FlipRule::crease_preserving), std::pair("sphere", FlipRule::curvature_aligned)}) {
        const auto log = read_bytes(std::string(name) + ".arl");
        const Header header = read_layout(log).header;
        CHECK(header.rules.flip_rule == flip_rule);
        CHECK(header.rules.ring_smoothing == RingSmoothing::sixteenth);
        check_expectations(log, nlohmann::json::parse(read_text(std::string(name) + ".json")));
    }
}

TEST_CASE("Golden: the packed log has the refinements of the other in fewer frames") {
    CHECK(verify_log(read_bytes("icosphere.arl")) == 1 + 2 + 2 * 24 + 1);
    CHECK(verify_log(read_bytes("icosphere-packed.arl")) == 1 + 2 + 2 * 4 + 1);
}

TEST_CASE("Golden: today's writer writes the recorded bytes") {
    CHECK(samples::octahedron_log().live == read_bytes("octahedron.arl"));
    const auto sample = samples::icosphere_log();
    CHECK(seal_log(sample.live, sample.rows, {.splits_per_packet = 0}) == read_bytes("icosphere.arl"));
    CHECK(seal_log(sample.live, sample.rows, largest_packets(128)) == read_bytes("icosphere-packed.arl"));
    const auto cube = samples::cube_log();
    CHECK(seal_log(cube.live, cube.rows, largest_packets(128)) == read_bytes("cube.arl"));
    const auto sphere = samples::sphere_log();
    CHECK(seal_log(sphere.live, sphere.rows, largest_packets(128)) == read_bytes("sphere.arl"));
}

TEST_CASE("Golden: the bytes listed in FORMAT.md are those of the file") {
    std::ifstream format(FORMAT_FILE);
    REQUIRE(format.good());
    const std::regex listing("([0-9a-f]{4}):((?: [0-9a-f]{2})+)");
    std::vector<std::byte> listed;
    std::smatch match;
    for (std::string line; std::getline(format, line);) {
        if (!std::regex_match(line, match, listing)) continue;
        CHECK(std::stoul(match[1], nullptr, 16) == listed.size());
        std::istringstream values(match[2]);
        for (unsigned value; values >> std::hex >> value;) listed.push_back(static_cast<std::byte>(value));
    }
    CHECK(listed == read_bytes("octahedron.arl"));
}

TEST_CASE("Golden: the worked example is what FORMAT.md says of it") {
    const auto log = read_bytes("octahedron.arl");
    const LogLayout layout = read_layout(log);
    const FrameType expected[] = {FrameType::base, FrameType::colour, FrameType::refine, FrameType::colour,
                                  FrameType::end};
    REQUIRE(layout.frames.size() == std::size(expected));
    for (std::size_t i = 0; i < layout.frames.size(); ++i) CHECK(layout.frames[i].type == expected[i]);
    CHECK(layout.frames[2].state_hash == 0x1cc5311a);

    const RefinableMesh all = state_at(log, 12);
    CHECK(all.positions()[10] == GridPoint{814, 528, 799});
    CHECK(all.triangles()[12] == Triangle{9, 1, 3});
    CHECK(decode_mesh(log, VertexBudget{12}).colours[11] == Rgb8{145, 112, 132});
    const RefinableMesh first_split = state_at(log, 11);
    CHECK(first_split.state_hash() == 0x1735f175);
    CHECK(first_split.positions()[8] == GridPoint{222, 222, 523});
    CHECK(first_split.triangles()[12] == Triangle{7, 1, 3});
}

}  // namespace anyrate
