#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "proto/log_writer.h"
#include "tests/unit/proto/log_fixture.h"

namespace anyrate {
namespace {

const Grid grid = samples::unit_grid(14);

struct Log {
    std::vector<std::byte> bytes;
    LogWriter writer{1,
                     [this](std::span<const std::byte> part) { bytes.insert(bytes.end(), part.begin(), part.end()); }};
};

std::vector<SplitRecord> split_every(RefinableMesh& mesh, std::int32_t stride, std::size_t n_wanted) {
    std::vector<SplitRecord> records;
    const std::int32_t n_faces = mesh.n_faces();
    for (std::int32_t f = 0; f < n_faces && records.size() < n_wanted; f += stride) {
        if (mesh.split_site(f))
            records.push_back(
                mesh.split(f, [&](const ScalarSite& s) { return samples::towards_bumpy_sphere(grid, s); }));
    }
    return records;
}

}  // namespace

TEST_CASE("Log writer: a batch of more than 2048 splits spans packets, and the gaps go on") {
    Log log;
    RefinableMesh mesh(log.writer.start(grid, {}, samples::icosphere(grid, 4)), grid, {});
    log.writer.base_attributes({}, {5, 10});
    const auto records = split_every(mesh, 1, 4500);
    REQUIRE(records.size() == 4500);
    log.writer.batch(records, mesh, {}, {1, 2});
    log.writer.finish();

    const LogLayout layout = read_layout(log.bytes);
    REQUIRE(layout.frames.size() == 5);  // base, three packets, end
    CHECK(layout.frames[1].flags == frame_flag_new_batch);
    CHECK(layout.frames[2].flags == 0);
    CHECK(layout.frames[3].flags == 0);
    CHECK(verify_log(log.bytes) == 5);
    // Only the last packet knows what the batch has reached.
    const auto rows = log.writer.rows();
    CHECK(rows[1].mean_distortion == 5);
    CHECK(rows[2].mean_distortion == 5);
    CHECK(rows[3].mean_distortion == 1);
}

TEST_CASE("Log writer: one call of the sink is one header or one whole frame") {
    std::vector<std::size_t> sizes;
    LogWriter writer(1, [&](std::span<const std::byte> part) { sizes.push_back(part.size()); });
    RefinableMesh mesh(writer.start(grid, {}, samples::icosphere(grid, 1)), grid, {});
    CHECK(sizes.size() == 2);
    CHECK(sizes[0] == header_size);
    writer.base_attributes({}, {1, 1});
    writer.batch(split_every(mesh, 9, 5), mesh, {}, {1, 1});
    CHECK(sizes.size() == 3);
    CHECK(writer.rows().back().end == sizes[1] + sizes[2]);
    writer.finish();
    CHECK(sizes.back() == frame_header_size);
}

TEST_CASE("Log writer: the base's distortion is unknown until its attributes come") {
    Log log;
    log.writer.start(grid, {}, samples::icosphere(grid, 1));
    REQUIRE(log.writer.rows().size() == 1);
    CHECK(std::isnan(log.writer.rows()[0].mean_distortion));
    log.writer.base_attributes({}, {7, 9});
    CHECK(log.writer.rows()[0].mean_distortion == 7);
}

TEST_CASE("Log writer: records that do not lead to the state are refused, and nothing is written") {
    Log log;
    RefinableMesh mesh(log.writer.start(grid, {}, samples::icosphere(grid, 1)), grid, {});
    log.writer.base_attributes({}, {1, 1});
    auto records = split_every(mesh, 9, 5);
    records[2].update[0] += 3;
    const std::size_t size = log.bytes.size();
    CHECK_THROWS_AS(log.writer.batch(records, mesh, {}, {1, 1}), InputError);
    CHECK(log.bytes.size() == size);
}

TEST_CASE("Log writer: colours come for all vertices or for none") {
    Log log;
    RefinableMesh mesh(log.writer.start(grid, {}, samples::icosphere(grid, 1)), grid, {});
    CHECK_THROWS_AS(log.writer.base_attributes(std::vector<Rgb8>(41), {1, 1}), InputError);
    log.writer.base_attributes(std::vector<Rgb8>(42), {1, 1});
    const auto records = split_every(mesh, 9, 5);
    CHECK_THROWS_AS(log.writer.batch(records, mesh, std::vector<Rgb8>(14), {1, 1}), InputError);
    CHECK_THROWS_AS(log.writer.batch(records, mesh, {}, {1, 1}), InputError);
}

TEST_CASE("Log writer: calls out of order are refused") {
    Log log;
    CHECK_THROWS_AS(log.writer.base_attributes({}, {1, 1}), InputError);
    CHECK_THROWS_AS(log.writer.finish(), InputError);
    log.writer.start(grid, {}, samples::icosphere(grid, 1));
    CHECK_THROWS_AS(log.writer.start(grid, {}, samples::icosphere(grid, 1)), InputError);
    log.writer.finish();
    CHECK_THROWS_AS(log.writer.base_attributes({}, {1, 1}), InputError);
}

TEST_CASE("Log writer: a base that is no closed manifold is refused before anything is written") {
    Log log;
    BaseMesh open = samples::icosphere(grid, 1);
    open.triangles.pop_back();
    CHECK_THROWS_AS(log.writer.start(grid, {}, open), InputError);
    CHECK(log.bytes.empty());
}

TEST_CASE("Log writer: an empty batch writes nothing") {
    Log log;
    const RefinableMesh mesh(log.writer.start(grid, {}, samples::icosphere(grid, 1)), grid, {});
    const std::size_t size = log.bytes.size();
    log.writer.batch({}, mesh, {}, {1, 1});
    CHECK(log.bytes.size() == size);
}

TEST_CASE("Log writer: a torus stays a torus through the log") {
    Log log;
    RefinableMesh mesh(log.writer.start(grid, {}, samples::square_torus(grid)), grid, {});
    log.writer.batch(split_every(mesh, 5, 10), mesh, {}, {1, 1});
    log.writer.finish();
    const Mesh decoded = decode_mesh(log.bytes, VertexBudget{0xFFFFFFFF});
    CHECK(decoded.n_faces() == 2 * decoded.n_vertices());  // V - E + F = 0 with E = 3 F / 2
}

TEST_CASE("Log writer: a log that is continued behind any batch ends like one that was written at once") {
    struct Step {
        std::vector<SplitRecord> records;
        RefinableMesh after;
        std::size_t n_bytes, n_rows;  // of the log before it
    };
    for (const bool coloured : {true, false}) {
        Log log;
        RefinableMesh mesh(log.writer.start(grid, {}, samples::icosphere(grid, 3)), grid, {});
        const auto n_base = static_cast<std::size_t>(mesh.n_vertices());
        log.writer.base_attributes(std::vector<Rgb8>(coloured ? n_base : 0, Rgb8{10, 90, 200}), {5, 10});
        const auto colours_of = [&](const Step& step) {
            std::vector<Rgb8> colours;
            for (std::size_t i = 0; coloured && i < 3 * step.records.size(); ++i)
                colours.push_back({static_cast<std::uint8_t>(7 * i), static_cast<std::uint8_t>(3 * i), 50});
            return colours;
        };
        std::vector<Step> steps;
        for (const std::size_t n_splits : {40, 2100, 60}) {  // the second one spans packets
            Step step{split_every(mesh, n_splits > 2048 ? 1 : 17, n_splits), mesh, log.bytes.size(),
                      log.writer.rows().size()};
            log.writer.batch(step.records, mesh, colours_of(step), {1.0 / (1.0 + static_cast<double>(n_splits)), 1});
            steps.push_back(std::move(step));
        }
        log.writer.finish();
        const std::vector<IndexRow> rows(log.writer.rows().begin(), log.writer.rows().end());
        for (std::size_t begin = 0; begin < steps.size(); ++begin) {
            std::vector<std::byte> rest;
            LogWriter writer(
                std::span(log.bytes).first(steps[begin].n_bytes), std::span(rows).first(steps[begin].n_rows),
                [&](std::span<const std::byte> part) { rest.insert(rest.end(), part.begin(), part.end()); });
            for (std::size_t k = begin; k < steps.size(); ++k)
                writer.batch(steps[k].records, steps[k].after, colours_of(steps[k]),
                             {1.0 / (1.0 + (k == 0   ? 40.0
                                            : k == 1 ? 2100.0
                                                     : 60.0)),
                              1});
            writer.finish();
            CHECK(std::ranges::equal(rest, std::span(log.bytes).subspan(steps[begin].n_bytes)));
            CHECK(std::ranges::equal(writer.rows(), rows));
        }
    }
}

TEST_CASE("Log writer: what cannot be continued is refused") {
    const auto& log = testing::small_log();
    const LogLayout layout = read_layout(log.live);
    const auto refused = [](std::span<const std::byte> front, std::span<const IndexRow> rows) {
        CHECK_THROWS_AS(LogWriter(front, rows, [](std::span<const std::byte>) {}), DecodeError);
    };
    const std::size_t end = layout.frames[1].end();
    CHECK_NOTHROW(
        LogWriter(std::span(log.live).first(end), std::span(layout.index).first(2), [](std::span<const std::byte>) {}));
    refused(std::span(log.live).first(end), std::span(layout.index).first(1));
    refused(std::span(log.live).first(end - 1), std::span(layout.index).first(2));
    refused(std::span(log.live).first(header_size), {});
    refused(log.live, layout.index);  // it has ended
    std::vector<std::byte> damaged(log.live.begin(), log.live.begin() + static_cast<std::ptrdiff_t>(end));
    damaged[end - 1] ^= std::byte{1};
    refused(damaged, std::span(layout.index).first(2));
}

}  // namespace anyrate
