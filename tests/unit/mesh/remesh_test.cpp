#include "core/mesh/remesh.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.h"
#include "core/mesh/edges.h"
#include "core/mesh/nearest_surface.h"
#include "core/mesh/topology.h"
#include "core/mesh/triangle_shape.h"
#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

namespace {

std::vector<double> edge_lengths(const Mesh& mesh) {
    const EdgeList edges = list_edges(mesh);
    std::vector<double> lengths;
    for (int e = 0; e < edges.n_edges(); ++e) {
        const auto h = edges.edge(e)[0];
        lengths.push_back((mesh.vertices[target(mesh, h)] - mesh.vertices[origin(mesh, h)]).norm());
    }
    return lengths;
}

double mean_quality(const Mesh& mesh) {
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        sum += triangle_quality(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
    return sum / mesh.n_faces();
}

/// The largest distance of a vertex of one mesh from the surface of the other.
double vertex_distance(const Mesh& from, const Mesh& to) {
    const NearestSurface surface(to);
    double largest = 0;
    for (const Vec3& v : from.vertices) largest = std::max(largest, surface.nearest(v).squared_distance);
    return std::sqrt(largest);
}

/// Two balls joined by a rod of the given radius along x, from -0.8 to 0.8; a thin finger sticks out of the right one.
Mesh thin_shape(double radius, int n) {
    return shapes::zero_set(
        [=](const Vec3& p) {
            const auto capsule = [&](const Vec3& a, const Vec3& b, double r) {
                const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
                return (p - a - t * (b - a)).norm() - r;
            };
            return std::min(capsule({-0.5, 0, 0}, {-0.4, 0, 0}, 0.35),
                            capsule({-0.4, 0, 0}, {0.85, 0.01, 0.02}, radius));
        },
        n);
}

}  // namespace

TEST_CASE("remesh: a sphere by marching tetrahedra becomes even, closed, and stays on the sphere's mesh") {
    const Mesh sphere = shapes::zero_set([](const Vec3& p) { return p.norm() - 0.8; }, 48);
    for (const int n : {200, 1000}) {
        CAPTURE(n);
        const Mesh even = remesh_isotropic(sphere, {.n_vertices = n});
        const Topology topology = measure_topology(even);
        CHECK(std::abs(even.n_vertices() - n) <= 0.005 * n);
        CHECK(topology.is_closed_manifold());
        CHECK(topology.euler == 2);
        CHECK(vertex_distance(even, sphere) < 1e-9);
        CHECK(mean_quality(even) > 0.95);
        // A regular triangulation of area A has edges of length sqrt(2 A / (sqrt(3) n)).
        const double expected = std::sqrt(8 * std::numbers::pi * 0.64 / (std::numbers::sqrt3 * n));
        const std::vector<double> lengths = edge_lengths(even);
        CHECK(*std::ranges::min_element(lengths) > 0.6 * expected);
        CHECK(*std::ranges::max_element(lengths) < 1.5 * expected);
    }
}

TEST_CASE("remesh: a torus keeps its hole") {
    const Mesh even = remesh_isotropic(torus(2, 0.5, 120, 40), {.n_vertices = 600});
    CHECK(even.n_vertices() == 600);
    CHECK(measure_topology(even).is_closed_manifold());
    CHECK(measure_topology(even).euler == 0);
    CHECK(mean_quality(even) > 0.95);
}

TEST_CASE("remesh: a coarse input is refined to the count") {
    const Mesh even = remesh_isotropic(icosphere(0), {.n_vertices = 500});
    CHECK(even.n_vertices() == 500);
    CHECK(measure_topology(even).is_closed_manifold());
    CHECK(vertex_distance(even, icosphere(0)) < 1e-9);
}

TEST_CASE("remesh: triangles face outwards, as on the input") {
    const Mesh even =
        remesh_isotropic(shapes::zero_set([](const Vec3& p) { return p.norm() - 0.8; }, 40), {.n_vertices = 400});
    for (const auto& [a, b, c] : even.triangles) {
        const Vec3 &p = even.vertices[a], &q = even.vertices[b], &r = even.vertices[c];
        CHECK(twice_area_vector(p, q, r).normalized().dot((p + q + r).normalized()) > 0.9);
    }
}

TEST_CASE("remesh: a finger thinner than the edges keeps its tip and its shape") {
    for (const double radius : {0.06, 0.03}) {
        CAPTURE(radius);
        const Mesh shape = thin_shape(radius, 80);
        const Mesh even = remesh_isotropic(shape, {.n_vertices = 300});
        const Topology topology = measure_topology(even);
        CHECK(topology.is_closed_manifold());
        CHECK(topology.euler == 2);
        const std::vector<double> lengths = edge_lengths(even);
        const double mean = std::accumulate(lengths.begin(), lengths.end(), 0.0) / static_cast<double>(lengths.size());
        CHECK(mean > 1.3 * radius);  // the finger is thin indeed
        // No point of the input, the tip least of all, is further from the result than an edge is long.
        CHECK(vertex_distance(shape, even) < mean);
    }
}

TEST_CASE("remesh: where even edges miss the shape, detail makes them half as long, and nowhere else") {
    const Mesh shape = thin_shape(0.06, 80);
    const auto mean_edge = [](const Mesh& mesh, bool of_finger) {
        double sum = 0;
        int n = 0;
        const EdgeList edges = list_edges(mesh);
        for (int e = 0; e < edges.n_edges(); ++e) {
            const auto h = edges.edge(e)[0];
            const Vec3 &a = mesh.vertices[origin(mesh, h)], &b = mesh.vertices[target(mesh, h)];
            const double x = 0.5 * (a + b).x();  // the ball ends at -0.05, the finger at 0.91
            if (of_finger ? x < 0.2 : x > -0.4) continue;
            sum += (a - b).norm();
            ++n;
        }
        return sum / n;
    };
    const Mesh even = remesh_isotropic(shape, {.n_vertices = 300});
    const Mesh detailed = remesh_isotropic(shape, {.n_vertices = 300, .detail = 0.05});
    CHECK(measure_topology(detailed).is_closed_manifold());
    CHECK(measure_topology(detailed).euler == 2);
    CHECK(detailed.n_vertices() > 300);
    CHECK(mean_edge(detailed, true) < 0.7 * mean_edge(even, true));
    CHECK(mean_edge(detailed, false) == doctest::Approx(mean_edge(even, false)).epsilon(0.1));
    CHECK(vertex_distance(shape, detailed) < 0.7 * vertex_distance(shape, even));
}

TEST_CASE("remesh: a sphere has no detail that even edges miss") {
    const Mesh sphere = icosphere(5);
    CHECK(std::abs(remesh_isotropic(sphere, {.n_vertices = 1000, .detail = 0.1}).n_vertices() - 1000) <= 20);
}

TEST_CASE("remesh: the same input gives the same mesh") {
    const Mesh shape = thin_shape(0.06, 40);
    const Mesh first = remesh_isotropic(shape, {.n_vertices = 300}),
               second = remesh_isotropic(shape, {.n_vertices = 300});
    CHECK(first.vertices == second.vertices);
    CHECK(first.triangles == second.triangles);
}

TEST_CASE("remesh: an object of a metre far from the origin is remeshed like one at home") {
    const Mesh far = shapes::translated(icosphere(4), {4.5e6, 5.1e5, -120});
    const Mesh even = remesh_isotropic(far, {.n_vertices = 300});
    CHECK(even.n_vertices() == 300);
    CHECK(mean_quality(even) > 0.95);
}

TEST_CASE("remesh: an open mesh and too small a count are refused") {
    Mesh open = icosphere(2);
    open.triangles.pop_back();
    CHECK_THROWS_AS(remesh_isotropic(open, {.n_vertices = 50}), InputError);
    CHECK_THROWS_AS(remesh_isotropic(icosphere(2), {.n_vertices = 3}), InputError);
    CHECK_THROWS_AS(remesh_isotropic(torus(2, 0.5, 40, 20), {.n_vertices = 5}), InputError);
}
