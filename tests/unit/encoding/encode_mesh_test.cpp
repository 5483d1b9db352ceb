#include "core/encoding/encode_mesh.h"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "core/error.h"
#include "core/mesh/topology.h"
#include "core/simulation/parametric_meshes.h"
#include "proto/header.h"
#include "proto/log_reader.h"
#include "proto/log_writer.h"
#include "tests/scenes.h"

using namespace anyrate;

namespace {

struct Encoded {
    EncodeEnd end = EncodeEnd::done;
    std::vector<std::byte> log;  ///< live
    std::vector<IndexRow> rows;
};

Encoded encode(const Mesh& mesh, const EncodeMeshOptions& options,
               const std::function<void(const EncodeProgress&)>& progress = {}, const std::stop_token& stop = {}) {
    Encoded result;
    LogWriter writer(
        1, [&](std::span<const std::byte> bytes) { result.log.insert(result.log.end(), bytes.begin(), bytes.end()); });
    result.end = encode_mesh(mesh, options, writer, progress, stop);
    result.rows.assign(writer.rows().begin(), writer.rows().end());
    return result;
}

/// Mean squared distance of the unit sphere from n vertices at their best: 2 n equilateral triangles of circumradius r,
/// each at the height where it is off least, err by r^4 / 4 times the variance of (|x| / r)^2 on one, which is 9 / 240.
double least_distortion_of_sphere(int n_vertices) {
    const double area = 2 * std::numbers::pi / n_vertices, r_squared = 4 * area / (3 * std::sqrt(3.0));
    return r_squared * r_squared / 4 * 9 / 240;
}

const EncodeMeshOptions small{.n_vertices = 2000, .n_coarse = 200};

}  // namespace

TEST_CASE(
    "Encode mesh: the log of a sphere verifies, meets its count, and nears the sphere with the square of its "
    "vertices") {
    const Encoded sphere = encode(icosphere(5), small);
    CHECK(sphere.end == EncodeEnd::done);
    CHECK(verify_log(sphere.log) == sphere.rows.size() + 1);
    CHECK(sphere.rows.front().n_vertices == 200);
    CHECK(sphere.rows.back().n_vertices > 2000 - 3);
    CHECK(sphere.rows.back().n_vertices <= 2000);
    for (std::size_t i = 1; i < sphere.rows.size(); ++i)
        CHECK(sphere.rows[i].mean_distortion < sphere.rows[i - 1].mean_distortion);
    const double unit = decode_header(sphere.log).grid.unit;
    const auto times_the_least = [&](const IndexRow& row) {
        return row.mean_distortion * unit * unit / least_distortion_of_sphere(static_cast<int>(row.n_vertices));
    };
    CHECK(times_the_least(sphere.rows.front()) < 1.6);
    CHECK(times_the_least(sphere.rows.back()) < 8);  // splits place their vertices less freely than the base's are
}

TEST_CASE("Encode mesh: every prefix of a torus is a torus") {
    const Encoded log = encode(torus(1, 0.4, 80, 40), {.n_vertices = 1200, .n_coarse = 150});
    for (unsigned n = 150; n <= 1200; n += 131) {
        const Topology topology = measure_topology(decode_mesh(log.log, VertexBudget{n}));
        CHECK(topology.is_closed_manifold());
        CHECK(topology.n_components == 1);
        CHECK(topology.euler == 0);
    }
}

TEST_CASE("Encode mesh: a plane surface, which a few vertices show without error, meets its count too") {
    const Encoded cube = encode(cube_surface(12), {.n_vertices = 600, .n_coarse = 100});
    CHECK(cube.rows.back().n_vertices > 600 - 3);
}

TEST_CASE("Encode mesh: one thread and two give the same bytes") {
    std::vector<std::byte> logs[2];
    for (std::size_t i = 0; i < 2; ++i) {
        const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, i + 1);
        logs[i] = encode(torus(1, 0.4, 80, 40), {.n_vertices = 1200, .n_coarse = 150}).log;
    }
    CHECK(logs[0] == logs[1]);
}

TEST_CASE("Encode mesh: the vertices' colours travel along") {
    Mesh mesh = icosphere(4);
    for (const Vec3& v : mesh.vertices) mesh.colours.push_back({static_cast<std::uint8_t>(127 + 100 * v.x()), 60, 200});
    const Mesh decoded = decode_mesh(encode(mesh, {.n_vertices = 600, .n_coarse = 150}).log, VertexBudget{600});
    REQUIRE(decoded.colours.size() == decoded.vertices.size());
    double sum = 0;
    for (std::size_t v = 0; v < decoded.vertices.size(); ++v) {
        const double error = std::abs(decoded.colours[v].r - (127 + 100 * decoded.vertices[v].normalized().x()));
        CHECK(error < 16);
        sum += error;
    }
    CHECK(sum / static_cast<double>(decoded.vertices.size()) < 3);
}

TEST_CASE("Encode mesh: a stop leaves a valid model that ends at the batch") {
    std::stop_source stop;
    int n_stopped = 0;
    const Encoded log = encode(
        icosphere(4), small,
        [&](const EncodeProgress& progress) {
            if (progress.n_vertices < 500) return;
            n_stopped = progress.n_vertices;
            stop.request_stop();
        },
        stop.get_token());
    CHECK(log.end == EncodeEnd::stopped);
    CHECK(verify_log(log.log) > 2);
    CHECK(static_cast<int>(log.rows.back().n_vertices) == n_stopped);
    CHECK(n_stopped < 1500);
}

TEST_CASE("Encode mesh: stopped before the base, nothing is written") {
    std::stop_source stop;
    stop.request_stop();
    const Encoded log = encode(icosphere(3), small, {}, stop.get_token());
    CHECK(log.end == EncodeEnd::before_the_base);
    CHECK(log.log.empty());
}

TEST_CASE("Encode mesh: counts out of range are refused") {
    CHECK_THROWS_AS(encode(icosphere(3), {.n_vertices = 99, .n_coarse = 99}), InputError);
    CHECK_THROWS_AS(encode(icosphere(3), {.n_vertices = 300, .n_coarse = 301}), InputError);
    CHECK_THROWS_AS(encode(icosphere(3), {.n_vertices = 1'000'001, .n_coarse = 1000}), InputError);
}
