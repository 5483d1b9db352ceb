#include <doctest/doctest.h>

#include <random>
#include <stdexcept>

#include "core/error.h"
#include "tests/golden/sample_models.h"
#include "tests/unit/progressive/closed_manifold.h"

namespace anyrate {
namespace {

const Grid grid = samples::unit_grid(12);

}  // namespace

TEST_CASE("RefinableMesh: replaying the records gives the encoder's state, bit for bit, after every split") {
    RefinableMesh encoder(samples::icosphere(grid, 1), grid, {});
    RefinableMesh decoder = encoder;
    std::mt19937 random(1);
    for (int k = 0; k < 400; ++k) {
        const auto face = static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(encoder.n_faces()));
        if (!encoder.split_site(face)) continue;
        decoder.apply(
            encoder.split(face, [&](const ScalarSite& site) { return samples::towards_bumpy_sphere(grid, site); }));
        REQUIRE(testing::same_state(encoder, decoder));
    }
    CHECK(testing::fault_of(decoder) == "");
}

TEST_CASE("RefinableMesh: a record that leaves the grid is refused and leaves no trace") {
    RefinableMesh mesh(samples::icosphere(grid, 1), grid, {});
    const RefinableMesh before = mesh;
    SplitRecord record{.face = 11, .residual = {1, 2, 3}, .update = {1, -1, 2, -2, 3, -3}};
    SUBCASE("by the first new vertex") { record.residual[0] = 100'000; }
    SUBCASE("by the last new vertex") { record.residual[2] = -100'000; }
    SUBCASE("by the last apex, when all else is done") { record.update[5] = 2'000'000'000; }
    CHECK_THROWS_AS(mesh.apply(record), DecodeError);
    REQUIRE(testing::same_state(mesh, before));

    RefinableMesh other = before;  // what cannot be seen, such as where rings start, is restored too
    for (const std::int32_t face : {11, 12, 40, 41, 80}) {
        if (!mesh.split_site(face)) continue;
        const SplitRecord sound{.face = face, .residual = {4, -4, 4}};
        mesh.apply(sound);
        other.apply(sound);
    }
    CHECK(testing::same_state(mesh, other));
}

TEST_CASE("RefinableMesh: what the chooser throws leaves no trace either") {
    RefinableMesh mesh(samples::icosphere(grid, 1), grid, {});
    const RefinableMesh before = mesh;
    const auto give_up = [](const ScalarSite& site) { return site.slot < 7 ? 1 : throw std::runtime_error("enough"); };
    CHECK_THROWS_AS(mesh.split(11, give_up), std::runtime_error);
    CHECK(testing::same_state(mesh, before));
}

TEST_CASE("RefinableMesh: copies are independent") {
    RefinableMesh mesh(samples::icosphere(grid, 1), grid, {});
    RefinableMesh copy = mesh;
    copy.apply({.face = 3});
    CHECK(mesh.n_vertices() == 42);
    mesh.apply({.face = 3});
    CHECK(testing::same_state(mesh, copy));
}

TEST_CASE("RefinableMesh: to_mesh gives world units") {
    const RefinableMesh mesh(samples::octahedron(grid), grid, {});
    const Mesh world = mesh.to_mesh();
    REQUIRE(world.n_vertices() == 6);
    REQUIRE(world.n_faces() == 8);
    for (const Vec3& p : world.vertices) CHECK(p.norm() == doctest::Approx(0.75));
}

}  // namespace anyrate
