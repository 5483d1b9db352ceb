#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "core/reconstruction/flow.h"
#include "core/reconstruction/mean_curvature.h"
#include "core/reconstruction/tangential.h"
#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

TEST_CASE("Eq. 3: the curvature normal of a sphere of radius R is 1/R inward") {
    for (double R : {0.5, 1.0, 40.0}) {
        const Mesh mesh = icosphere(4, R, Vec3(3, -2, 1));
        const OneRings rings(mesh);
        const auto H = mean_curvature_normals(mesh, rings);
        for (std::size_t v = 0; v < H.size(); ++v) {
            const Vec3 outward = (mesh.vertices[v] - Vec3(3, -2, 1)) / R;
            CHECK(H[v].dot(outward) == doctest::Approx(-1 / R).epsilon(0.02));
        }
    }
}

TEST_CASE("Eq. 3: where G is constant the flow shrinks a sphere at the rate G/R") {
    const double R = 2.0, G = 3.0;
    const Mesh mesh = icosphere(4, R);
    const OneRings rings(mesh);
    const auto normals = vertex_normals(mesh, rings);
    const std::vector<std::optional<double>> distortion(normals.size(), G), gradient(normals.size(), 0.0);
    const std::vector<double> bounds(normals.size(), 1e-3);
    const auto step = flow_step(distortion, gradient, mean_curvature_normals(mesh, rings), normals, bounds);
    // Nine of ten vertices stay within their bound: all speeds are G/R up to discretisation, so all steps are near it.
    for (std::size_t v = 0; v < step.size(); ++v) {
        CHECK(step[v].dot(normals[v]) < 0);
        CHECK(step[v].norm() == doctest::Approx(1e-3).epsilon(0.05));
    }
}

TEST_CASE("Eq. 3: the gradient term moves a vertex to where G is lower") {
    const Mesh mesh = icosphere(2);
    const OneRings rings(mesh);
    const auto normals = vertex_normals(mesh, rings);
    std::vector<std::optional<double>> G(normals.size(), 0.0), gradient(normals.size(), 0.0);
    gradient[5] = 4.0;   // G rises outward
    gradient[9] = -4.0;  // G falls outward
    const std::vector<Vec3> flat(normals.size(), Vec3::Zero());
    const std::vector<double> bounds(normals.size(), 0.1);
    const auto step = flow_step(G, gradient, flat, normals, bounds);
    CHECK(step[5].dot(normals[5]) < 0);
    CHECK(step[9].dot(normals[9]) > 0);
}

TEST_CASE("Eq. 4: no vertex moves further than its Courant bound") {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 10);
    const Mesh mesh = icosphere(3);
    const OneRings rings(mesh);
    const auto normals = vertex_normals(mesh, rings);
    std::vector<std::optional<double>> G(normals.size()), gradient(normals.size());
    std::vector<double> bounds(normals.size());
    for (std::size_t v = 0; v < normals.size(); ++v) {
        G[v] = std::abs(noise(random));
        gradient[v] = noise(random);
        bounds[v] = 1e-4 * (1 + static_cast<double>(random() % 100));
    }
    const auto step = flow_step(G, gradient, mean_curvature_normals(mesh, rings), normals, bounds);
    for (std::size_t v = 0; v < step.size(); ++v) CHECK(step[v].norm() <= bounds[v] * (1 + 1e-12));
}

TEST_CASE("Eq. 12: the tangential Laplacian has no part along the normal and points to the middle of the ring") {
    Mesh mesh = icosphere(2);
    mesh.vertices[20] += 0.05 * Vec3(mesh.vertices[20].y(), -mesh.vertices[20].x(), 0.0);
    const OneRings rings(mesh);
    const auto normals = vertex_normals(mesh, rings);
    for (std::int32_t v = 0; v < mesh.n_vertices(); ++v) {
        const Vec3 d = tangential_laplacian(mesh, rings, normals[static_cast<std::size_t>(v)], v);
        CHECK(std::abs(d.dot(normals[static_cast<std::size_t>(v)])) < 1e-12);
    }
    Vec3 middle = Vec3::Zero();
    for (std::int32_t w : rings.neighbours(20)) middle += mesh.vertices[static_cast<std::size_t>(w)];
    middle /= rings.valence(20);
    const Vec3 d = tangential_laplacian(mesh, rings, normals[20], 20);
    CHECK((mesh.vertices[20] + d - middle).norm() < (mesh.vertices[20] - middle).norm());
}

TEST_CASE("Eqs. 3-12: the flow of a displaced sphere lowers Psi and comes nearer to the true one") {
    const Capture capture = painted_sphere(10, 128, wavy_paint);
    const PhotoImages images = make_photo_images(capture, 1);
    const auto backend = make_cpu_backend(images);
    Mesh mesh = icosphere(3, 1.02);
    const auto mean_error = [&] {
        double sum = 0;
        int n = 0;
        for (const Vec3& v : mesh.vertices)
            if (std::abs(v.z()) < 0.6) {  // what the ring of cameras sees well
                sum += std::abs(v.norm() - 1.0);
                ++n;
            }
        return sum / n;
    };
    const double before = mean_error();
    double first = 0, last = 0;
    surface_flow(*backend, mesh.vertices, mesh.triangles, {.max_iterations = 25}, [&](int iteration, double psi) {
        if (iteration == 0) first = psi;
        last = psi;
    });
    CHECK(last < first);
    CHECK(mean_error() < 0.6 * before);
}
