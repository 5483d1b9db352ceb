#include <doctest/doctest.h>

#include "core/error.h"
#include "proto/log_writer.h"
#include "tests/unit/proto/log_fixture.h"

namespace anyrate {
namespace {

using testing::same_mesh;

/// The mesh after each whole frame of a sound log, base first.
std::vector<Mesh> meshes_of_prefixes(std::span<const std::byte> log) {
    std::vector<Mesh> meshes;
    for (const FrameInfo& frame : read_layout(log).frames) {
        ModelDecoder decoder;
        decoder.feed(log.first(static_cast<std::size_t>(frame.end())));
        if (decoder.state()) meshes.push_back(decoder.mesh());
    }
    return meshes;
}

/// Feeds what may be damaged. @return the mesh, if the bytes were taken and hold a base
std::optional<Mesh> mesh_unless_rejected(std::span<const std::byte> log) {
    try {
        ModelDecoder decoder;
        decoder.feed(log);
        return decoder.state() ? std::optional(decoder.mesh()) : std::nullopt;
    } catch (const DecodeError&) {
        return std::nullopt;
    }
}

void check_is_prefix(const std::optional<Mesh>& mesh, const std::vector<Mesh>& prefixes) {
    if (!mesh) return;
    REQUIRE(std::ranges::any_of(prefixes, [&](const Mesh& prefix) { return same_mesh(prefix, *mesh); }));
}

/// The golden logs of some hundred splits: too many for every damage to be decoded, so their framing has to tell.
std::vector<std::vector<std::byte>> larger_logs() {
    const samples::SampleLog sample = samples::icosphere_log(), cube = samples::cube_log(),
                             sphere = samples::sphere_log();
    return {seal_log(sample.live, sample.rows, {.splits_per_packet = 0}),
            seal_log(sample.live, sample.rows, largest_packets(128)),
            seal_log(cube.live, cube.rows, largest_packets(128)),
            seal_log(sphere.live, sphere.rows, largest_packets(128))};
}

void check_are_first_frames(const LogLayout& layout, const LogLayout& sound) {
    REQUIRE(layout.frames.size() <= sound.frames.size());
    for (std::size_t i = 0; i < layout.frames.size(); ++i) {
        REQUIRE(layout.frames[i].end() == sound.frames[i].end());
        REQUIRE(layout.frames[i].state_hash == sound.frames[i].state_hash);
    }
}

}  // namespace

TEST_CASE("Damage: every truncation of a log decodes to its last whole frame") {
    const auto live = samples::octahedron_log().live;
    const std::vector<std::byte> sealed = seal_log(live, {});
    for (const auto& log : {live, sealed}) {
        const auto frames = read_layout(log).frames;
        for (std::size_t size = header_size; size <= log.size(); ++size) {
            // A fresh allocation, so that the address sanitizer sees one byte too many.
            const std::vector<std::byte> cut(log.begin(), log.begin() + static_cast<std::ptrdiff_t>(size));
            const LogLayout layout = read_layout(cut);
            const auto n_whole = std::ranges::count_if(frames, [&](const FrameInfo& f) { return f.end() <= size; });
            REQUIRE(layout.frames.size() == static_cast<std::size_t>(n_whole));
            ModelDecoder decoder;
            decoder.feed(cut);
            const bool is_whole = layout.whole_bytes == size && decoder.state();
            if (is_whole) {
                CHECK_NOTHROW(verify_log(cut));
            } else {
                CHECK_THROWS_AS(verify_log(cut), DecodeError);
            }
            if (decoder.state()) {
                const auto whole = std::span(log).first(static_cast<std::size_t>(layout.whole_bytes));
                REQUIRE(same_mesh(decoder.mesh(), decode_mesh(whole, VertexBudget{0xFFFFFFFF})));
            }
        }
    }
}

TEST_CASE("Damage: every flipped bit is rejected or leaves a valid shorter prefix") {
    const auto live = samples::octahedron_log().live;
    const std::vector<std::byte> sealed = seal_log(live, {});
    for (const auto& log : {live, sealed}) {
        const std::vector<Mesh> prefixes = meshes_of_prefixes(log);
        for (std::size_t bit = 0; bit < 8 * log.size(); ++bit) {
            auto damaged = log;
            damaged[bit / 8] ^= std::byte{1} << (bit % 8);
            INFO("bit " << bit);
            check_is_prefix(mesh_unless_rejected(damaged), prefixes);
            CHECK_THROWS_AS(verify_log(damaged), DecodeError);
        }
    }
}

TEST_CASE("Damage: a larger log cut anywhere is known to be cut behind its whole frames") {
    for (const auto& log : larger_logs()) {
        const LogLayout sound = read_layout(log);
        for (std::size_t size = 0; size < log.size(); ++size) {
            const auto cut = std::span(log).first(size);
            if (size < header_size) {
                REQUIRE_THROWS_AS(read_layout(cut), DecodeError);
                continue;
            }
            const LogLayout layout = read_layout(cut);
            REQUIRE_FALSE(layout.ended);
            check_are_first_frames(layout, sound);
            REQUIRE((layout.frames.size() == sound.frames.size() || sound.frames[layout.frames.size()].end() > size));
        }
    }
}

TEST_CASE("Damage: a larger log cut at and around any frame's end decodes to its last whole frame") {
    for (const auto& log : larger_logs()) {
        const LogLayout sound = read_layout(log);
        for (const FrameInfo& frame : sound.frames) {
            for (const std::uint64_t size : {frame.end() - 1, frame.end(), frame.end() + 27}) {
                const auto cut =
                    std::span(log).first(static_cast<std::size_t>(std::min<std::uint64_t>(size, log.size())));
                ModelDecoder decoder;
                decoder.feed(cut);
                const LogLayout layout = read_layout(cut);
                if (layout.index.empty() || layout.frames.size() < 2) continue;  // no base yet
                REQUIRE(decoder.state()->n_vertices() == static_cast<int>(layout.frames.back().n_vertices_after));
            }
        }
    }
}

TEST_CASE("Damage: no flipped bit of a larger log goes unnoticed by its framing") {
    for (auto log : larger_logs()) {
        const LogLayout sound = read_layout(log);
        for (std::size_t bit = 0; bit < 8 * log.size(); ++bit) {
            log[bit / 8] ^= std::byte{1} << (bit % 8);
            INFO("bit " << bit);
            try {
                // A length that leads beyond the file looks like a cut: the frames before are undamaged.
                const LogLayout layout = read_layout(log);
                REQUIRE(layout.whole_bytes <= bit / 8);
                check_are_first_frames(layout, sound);
            } catch (const DecodeError&) {
            }
            log[bit / 8] ^= std::byte{1} << (bit % 8);
        }
    }
}

TEST_CASE("Damage: bytes behind the end frame are rejected, even one") {
    auto log = samples::octahedron_log().live;
    log.push_back(std::byte{0x50});
    CHECK_THROWS_AS(read_layout(log), DecodeError);
    ModelDecoder decoder;
    CHECK_THROWS_AS(decoder.feed(log), DecodeError);
}

TEST_CASE("Damage: frames that are left out, doubled or exchanged are rejected") {
    const auto& log = testing::small_log().live;
    const auto frames = read_layout(log).frames;
    const auto piece = [&](std::size_t i) {
        return std::span(log).subspan(static_cast<std::size_t>(frames[i].begin),
                                      static_cast<std::size_t>(frames[i].end() - frames[i].begin));
    };
    const auto log_of = [&](const std::vector<std::size_t>& order) {
        std::vector<std::byte> bytes(log.begin(), log.begin() + header_size);
        for (const std::size_t i : order) bytes.insert(bytes.end(), piece(i).begin(), piece(i).end());
        return bytes;
    };
    CHECK_NOTHROW(verify_log(log_of({0, 1, 2, 3})));
    CHECK_THROWS_AS(verify_log(log_of({0, 2, 3})), DecodeError);
    CHECK_THROWS_AS(verify_log(log_of({0, 1, 2, 2})), DecodeError);
    CHECK_THROWS_AS(verify_log(log_of({0, 1, 4, 5, 2, 3})), DecodeError);
    CHECK_THROWS_AS(verify_log(log_of({1, 2, 3})), DecodeError);
    CHECK_THROWS_AS(verify_log(log_of({})), DecodeError);
}

TEST_CASE("Damage: a wrong state hash is found though every checksum is right") {
    const auto& log = testing::small_log().live;
    for (const std::size_t i : {0, 1, 2, 3}) {  // base, its colours, a refinement, its colours
        FrameInfo frame = read_layout(log).frames[i];
        const auto payload =
            std::span(log).subspan(static_cast<std::size_t>(frame.begin) + frame_header_size, frame.payload_bytes);
        frame.state_hash ^= 1;
        std::vector<std::byte> bytes(log.begin(), log.begin() + static_cast<std::ptrdiff_t>(frame.begin));
        const auto forged = encode_frame(frame, payload);
        bytes.insert(bytes.end(), forged.begin(), forged.end());
        CHECK_NOTHROW(read_layout(bytes));
        CHECK_THROWS_AS(verify_log(bytes), DecodeError);
    }
}

TEST_CASE("Damage: an index that tells other frames than there are is rejected") {
    const auto sealed = seal_log(testing::small_log().live, testing::small_log().rows);
    const LogLayout layout = read_layout(sealed);
    auto rows = layout.index;
    rows.back().end += 1;
    std::vector<std::byte> forged(sealed.begin(), sealed.begin() + header_size);
    const auto index = encode_frame(layout.frames[0], encode_index_rows(rows));
    forged.insert(forged.end(), index.begin(), index.end());
    forged.insert(forged.end(), sealed.begin() + static_cast<std::ptrdiff_t>(layout.frames_begin), sealed.end());
    CHECK_THROWS_AS(read_layout(forged), DecodeError);
}

}  // namespace anyrate
