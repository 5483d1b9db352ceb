#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mesh/edges.h"
#include "core/mesh/homology.h"
#include "core/mesh/topology.h"
#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

namespace {

/// A ball with a straight tunnel of the given radius along z.
Mesh ball_with_tunnel(double radius, int n) {
    return shapes::zero_set(
        [=](const Vec3& p) { return std::max(p.norm() - 0.8, radius - std::hypot(p.x() - 0.013, p.y() - 0.017)); }, n);
}

/// A torus about the z axis, its tube crossed by a fine tunnel, with a thin bow of wire on top.
Mesh torus_with_noise(int n) {
    return shapes::zero_set(
        [](const Vec3& p) {
            const double torus = std::hypot(std::hypot(p.x(), p.y()) - 0.6, p.z()) - 0.25;
            const double tunnel = 0.05 - std::hypot(p.x() - 0.613, p.y() - 0.017);
            const Vec3 q = p - Vec3(-0.6, 0, 0.25);
            const double bow = std::hypot(std::hypot(q.x(), q.z()) - 0.12, q.y()) - 0.04;
            return std::min(std::max(torus, tunnel), bow);
        },
        n);
}

}  // namespace

TEST_CASE("homology: on a torus the circles both ways have a signature, the rim of a triangle has none") {
    const int around = 12, across = 8;
    const Mesh ring = torus(2, 1, around, across);
    const auto twin = twin_halfedges(ring);
    const auto signature = homology_signatures(ring, twin);
    const auto along = [&](int from, int to) {
        for (std::int32_t h = 0; h < 3 * ring.n_faces(); ++h)
            if (origin(ring, h) == from && target(ring, h) == to) return signature[h];
        FAIL("no such edge");
        return std::uint64_t{0};
    };
    std::uint64_t major = 0, minor = 0;
    for (int i = 0; i < around; ++i) major ^= along(i * across, (i + 1) % around * across);
    for (int j = 0; j < across; ++j) minor ^= along(j, (j + 1) % across);
    CHECK(major != 0);
    CHECK(minor != 0);
    CHECK(major != minor);
    for (std::int32_t f = 0; f < ring.n_faces(); ++f)
        CHECK((signature[3 * f] ^ signature[3 * f + 1] ^ signature[3 * f + 2]) == 0);
}

TEST_CASE("remove_small_handles: a ball loses its tunnel if the way around it is short enough, else keeps it") {
    const Mesh ball = ball_with_tunnel(0.1, 32);
    REQUIRE(measure_topology(ball).euler == 0);
    const double around = 2 * std::numbers::pi * 0.1;
    CHECK(measure_topology(remove_small_handles(ball, 0.8 * around)).euler == 0);
    const Topology closed = measure_topology(remove_small_handles(ball, 1.5 * around));
    CHECK(closed.is_closed_manifold());
    CHECK(closed.euler == 2);
    CHECK(closed.n_components == 1);
}

TEST_CASE("remove_small_handles: a torus keeps its own handle and loses a fine tunnel and a bow of wire") {
    const Mesh torus = torus_with_noise(48);
    REQUIRE(measure_topology(torus).euler == -4);
    const Mesh clean = remove_small_handles(torus, 0.6);
    const Topology topology = measure_topology(clean);
    CHECK(topology.is_closed_manifold());
    CHECK(topology.n_components == 1);
    CHECK(topology.euler == 0);
}

TEST_CASE("remove_small_handles: a lattice of fifty tunnels becomes a ball") {
    // A slab with a tunnel every 0.2 both ways; more handles than the bits of one round.
    const Mesh slab = shapes::zero_set(
        [](const Vec3& p) {
            const auto nearest = [](double x) { return x - 0.2 * std::round(x / 0.2); };
            const double hole = 0.05 - std::hypot(nearest(p.x()) + 0.003, nearest(p.y()) - 0.002);
            const Vec3 outside = p.cwiseAbs() - Vec3(0.7, 0.7, 0.08);
            return std::max(outside.maxCoeff(), hole);
        },
        50);
    const Topology before = measure_topology(slab);
    REQUIRE(before.is_closed_manifold());
    REQUIRE(before.euler == 2 - 2 * 49);
    const Topology after = measure_topology(remove_small_handles(slab, 0.6));
    CHECK(after.is_closed_manifold());
    CHECK(after.n_components == 1);
    CHECK(after.euler == 2);
}

TEST_CASE("remove_small_handles: genus zero comes back unchanged, also in pieces") {
    const Mesh both = shapes::together(icosphere(2), shapes::translated(icosphere(1), {5, 0, 0}));
    CHECK(remove_small_handles(both, 100).vertices == both.vertices);
}

TEST_CASE("remove_small_handles: colours stay one a vertex") {
    Mesh ring = torus(2, 0.5, 40, 12);
    ring.colours.assign(ring.vertices.size(), Rgb8{9, 8, 7});
    const Mesh cut = remove_small_handles(ring, 4);
    CHECK(measure_topology(cut).euler == 2);
    CHECK(cut.colours == std::vector<Rgb8>(cut.vertices.size(), Rgb8{9, 8, 7}));
}
