#include <doctest/doctest.h>

#include <cmath>

#include "core/reconstruction/distortion.h"
#include "core/reconstruction/flow.h"
#include "core/reconstruction/photo_backend.h"
#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

std::vector<TriangleQuery> whole(const Mesh& mesh) {
    std::vector<TriangleQuery> batch(mesh.triangles.size());
    for (std::size_t f = 0; f < batch.size(); ++f) {
        batch[f].face = static_cast<std::int32_t>(f);
        for (std::size_t k = 0; k < 3; ++k)
            batch[f].corners[k] = mesh.vertices[static_cast<std::size_t>(mesh.triangles[f][k])];
    }
    return batch;
}

struct Sphere {
    Capture capture = painted_sphere(12, 160, wavy_paint);
    PhotoImages images = make_photo_images(capture, 2);
    std::unique_ptr<PhotoBackend> backend = make_cpu_backend(images);

    double psi(const Mesh& mesh) {
        backend->set_surface(mesh, 0, 1.0);
        return surface_distortion(backend->distortions(whole(mesh)));
    }
};

}  // namespace

TEST_CASE("Eq. 8: phi of a triangle that all views see alike is zero, whatever its samples weigh") {
    const Capture plain = painted_sphere(12, 96, [](const Vec3&) { return Vec3(90, 120, 40); });
    const PhotoImages images = make_photo_images(plain, 1);
    const auto backend = make_cpu_backend(images);
    const Mesh mesh = icosphere(2, 0.97);
    backend->set_surface(mesh, 0, 1.0);
    double n_samples = 0;
    for (const TriangleDistortion& t : backend->distortions(whole(mesh))) {
        CHECK(t.phi == doctest::Approx(0.0));
        n_samples += t.n_samples;
    }
    CHECK(n_samples > 1000);
}

TEST_CASE("Eq. 9: G is the ring's phi per sample, and a ring without samples gives no evidence") {
    const Mesh mesh = icosphere(0);
    const OneRings rings(mesh);
    std::vector<TriangleDistortion> triangles(mesh.triangles.size());
    for (std::size_t f = 0; f < triangles.size(); ++f) triangles[f] = {static_cast<double>(f), 2.0};
    for (std::int32_t f : rings.faces(3)) triangles[static_cast<std::size_t>(f)] = {0.0, 0.0};
    const auto G = vertex_distortion(rings, mesh.n_vertices(), triangles);
    CHECK_FALSE(G[3].has_value());
    double phi = 0, n = 0;
    for (std::int32_t f : rings.faces(7)) {
        phi += triangles[static_cast<std::size_t>(f)].phi;
        n += triangles[static_cast<std::size_t>(f)].n_samples;
    }
    REQUIRE(G[7].has_value());
    CHECK(*G[7] == doctest::Approx(phi / n));
}

TEST_CASE("Eq. 10: Psi is the mean per sample, and nothing where there is no sample") {
    const std::vector<TriangleDistortion> triangles{{6.0, 2.0}, {0.0, 1.0}, {9.0, 3.0}};
    CHECK(surface_distortion(triangles) == doctest::Approx(15.0 / 6.0));
    CHECK(surface_distortion({}) == 0.0);
}

TEST_CASE("Eq. 10: Psi is lowest on the true surface and grows on both sides of it") {
    Sphere sphere;
    const double inside = sphere.psi(icosphere(4, 0.97)), truth = sphere.psi(icosphere(4, 1.0)),
                 outside = sphere.psi(icosphere(4, 1.03));
    CHECK(truth < 0.2 * inside);
    CHECK(truth < 0.2 * outside);
}

TEST_CASE("Eq. 11: the central difference of G converges with the square of its step") {
    Sphere sphere;
    const Mesh mesh = icosphere(3, 0.98);
    const OneRings rings(mesh);
    const auto normals = vertex_normals(mesh, rings);
    sphere.backend->set_surface(mesh, 0, 4.0);
    const auto difference = [&](double width) {
        const std::vector<double> widths(mesh.vertices.size(), width);
        return normal_gradient(*sphere.backend, mesh, rings, normals, widths);
    };
    const auto coarse = difference(0.02), fine = difference(0.01), finest = difference(0.005);
    double change_coarse = 0, change_fine = 0;
    for (std::size_t v = 0; v < normals.size(); ++v)
        if (coarse[v] && fine[v] && finest[v]) {
            change_coarse += std::abs(*coarse[v] - *fine[v]);
            change_fine += std::abs(*fine[v] - *finest[v]);
        }
    // The error of a step h is c h^2: halving it leaves a quarter of the change, up to the images' own roughness.
    CHECK(change_fine < 0.5 * change_coarse);
}

TEST_CASE("Eq. 11: the analytic derivative of phi agrees with the central difference") {
    Sphere sphere;
    const Mesh mesh = icosphere(3, 0.985);
    sphere.backend->set_surface(mesh, 0, 2.0);
    std::vector<TriangleQuery> batch = whole(mesh);
    const auto directions = corner_normals(mesh);
    const auto terms = sphere.backend->terms(batch, directions);

    constexpr double h = 2e-4;
    double error = 0, size = 0;
    for (std::size_t corner = 0; corner < 3; ++corner) {
        auto forward = batch, backward = batch;
        for (std::size_t f = 0; f < batch.size(); ++f) {
            forward[f].corners[corner] += h * directions[f][corner];
            backward[f].corners[corner] -= h * directions[f][corner];
        }
        const auto plus = sphere.backend->distortions(forward), minus = sphere.backend->distortions(backward);
        for (std::size_t f = 0; f < batch.size(); ++f) {
            if (plus[f].n_samples != minus[f].n_samples) continue;  // a sample crossed the silhouette
            const double numeric = (plus[f].phi - minus[f].phi) / (2 * h);
            error += std::abs(numeric - terms[f].gradient[corner]);
            size += std::abs(numeric);
        }
    }
    REQUIRE(size > 0);
    // Bilinear interpolation has kinks between the pixels, where the two differ.
    CHECK(error < 0.05 * size);
}
