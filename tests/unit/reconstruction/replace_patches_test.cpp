#include "core/reconstruction/replace_patches.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "core/mesh/topology.h"
#include "core/reconstruction/mend_patches.h"
#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

constexpr int n_views = 12, n_pixels = 160;

struct Scene {
    Capture capture;
    PhotoImages images = make_photo_images(capture, 3);
    Silhouettes silhouettes{capture};
    std::unique_ptr<PhotoBackend> backend = make_cpu_backend(images);

    explicit Scene(Capture captured = painted_sphere(n_views, n_pixels, wavy_paint)) : capture(std::move(captured)) {}

    void replace_patches(Mesh& mesh, std::span<char> is_guessed, const PatchOptions& options = {}) {
        const OneRings rings(mesh);
        FaceDistortions distortions(*backend, mesh);
        anyrate::replace_patches(*backend, silhouettes, rings, distortions, is_guessed, mesh, options);
    }
    void mend_patches(Mesh& mesh, std::vector<char>& is_guessed) {
        anyrate::mend_patches(*backend, silhouettes, FaceDistortions(*backend, mesh), 1, is_guessed, mesh);
    }
};

bool is_in_patch(const Vec3& v) { return v.normalized().x() > 0.95; }

// A unit sphere with a flap at +x, as high as a quarter of the radius, that leans over to +y.
Mesh flapped_sphere() {
    Mesh mesh = icosphere(3);
    for (Vec3& v : mesh.vertices)
        if (is_in_patch(v)) v += 6 * (v.x() - 0.95) * Vec3(0.8, 0.5, 0);
    return mesh;
}

// A unit sphere with a pit of the given depth at +x.
Mesh pitted_sphere(double depth) {
    Mesh mesh = icosphere(3);
    for (Vec3& v : mesh.vertices)
        if (is_in_patch(v)) v *= 1 - depth * (v.x() - 0.95) / 0.05;
    return mesh;
}

double farthest_off_sphere(const Mesh& mesh) {
    double farthest = 0;
    for (const Vec3& v : mesh.vertices) farthest = std::max(farthest, std::abs(v.norm() - 1));
    return farthest;
}

// Each view has other paint at +x than the others, so that no surface there agrees with them.
Capture contradictory_sphere() {
    Capture capture = painted_sphere(n_views, n_pixels, wavy_paint);
    for (std::size_t i = 0; i < capture.views.size(); ++i) {
        const auto of_this_view = [i](const Vec3& p) {
            const Vec3 turned = Eigen::AngleAxisd(1.7 * static_cast<double>(i), Vec3::UnitX()) * Vec3(2 * p);
            return is_in_patch(p) ? wavy_paint(turned) : wavy_paint(p);
        };
        capture.views[i].image = painted_sphere(n_views, n_pixels, of_this_view).views[i].image;
    }
    return capture;
}

}  // namespace

TEST_CASE("Replace patches: a flap that the photographs contradict gives way to the surface they show") {
    Scene scene;
    Mesh mesh = flapped_sphere();
    std::vector<char> is_guessed(mesh.vertices.size());
    for (std::size_t v = 0; v < is_guessed.size(); ++v) is_guessed[v] = mesh.vertices[v].norm() > 1.2;
    REQUIRE(std::ranges::count(is_guessed, 1) > 0);
    scene.replace_patches(mesh, is_guessed);
    for (const Vec3& v : mesh.vertices) CHECK(std::abs(v.norm() - 1) < 0.02);
    CHECK(std::ranges::count(is_guessed, 1) == 0);
}

TEST_CASE("Replace patches: a push leads out of a pit that the photographs alone do not lead out of") {
    const Mesh pitted = pitted_sphere(0.4);
    const auto pushed_by = [&](double n_edges) {
        Scene scene;
        Mesh mesh = pitted;
        std::vector<char> is_guessed(mesh.vertices.size());
        scene.replace_patches(mesh, is_guessed, {.push = n_edges});
        return mesh;
    };
    CHECK(farthest_off_sphere(pushed_by(0)) > 0.03);
    CHECK(farthest_off_sphere(pushed_by(1)) < 0.01);
    CHECK(pushed_by(-1).vertices == pitted.vertices);
}

TEST_CASE("Replace patches: what the photographs agree on stays where it is") {
    Scene scene;
    const Mesh sphere = icosphere(3);
    Mesh mesh = sphere;
    std::vector<char> is_guessed(mesh.vertices.size());
    scene.replace_patches(mesh, is_guessed);
    CHECK(mesh.vertices == sphere.vertices);
}

TEST_CASE(
    "Replace patches: where no surface agrees with the photographs a guess stays one, within an edge of where it was") {
    Scene scene(contradictory_sphere());
    Mesh mesh = icosphere(3);
    std::vector<char> is_guessed(mesh.vertices.size());
    for (std::size_t v = 0; v < is_guessed.size(); ++v) is_guessed[v] = is_in_patch(mesh.vertices[v]);
    const std::vector<char> guessed_before = is_guessed;
    scene.replace_patches(mesh, is_guessed);
    for (const Vec3& v : mesh.vertices) CHECK(std::abs(v.norm() - 1) < 0.14);
    CHECK(is_guessed == guessed_before);
}

TEST_CASE("Mend patches: a flap goes, and a mesh that agrees everywhere gets no more vertices") {
    Scene scene;
    Mesh mesh = flapped_sphere();
    std::vector<char> is_guessed(mesh.vertices.size());
    scene.mend_patches(mesh, is_guessed);
    for (const Vec3& v : mesh.vertices) CHECK(std::abs(v.norm() - 1) < 0.02);

    const Mesh sphere = icosphere(3);
    mesh = sphere;
    is_guessed.assign(mesh.vertices.size(), 0);
    scene.mend_patches(mesh, is_guessed);
    CHECK(mesh.vertices == sphere.vertices);
    CHECK(mesh.triangles == sphere.triangles);
}

TEST_CASE("Mend patches: where the photographs contradict each other edges are halved, and guesses stay guesses") {
    Scene scene(contradictory_sphere());
    const Mesh sphere = icosphere(3);
    Mesh mesh = sphere;
    std::vector<char> is_guessed(mesh.vertices.size());
    for (std::size_t v = 0; v < is_guessed.size(); ++v) is_guessed[v] = is_in_patch(mesh.vertices[v]);
    scene.mend_patches(mesh, is_guessed);

    CHECK(measure_topology(mesh).is_closed_manifold());
    CHECK(mesh.n_vertices() > sphere.n_vertices());
    CHECK(mesh.n_vertices() < 2 * sphere.n_vertices());
    for (auto v = sphere.vertices.size(); v < mesh.vertices.size(); ++v) CHECK(mesh.vertices[v].x() > 0.6);
    REQUIRE(is_guessed.size() == mesh.vertices.size());
    CHECK(std::ranges::count(is_guessed, 1) > 0);
    for (std::size_t v = 0; v < is_guessed.size(); ++v)
        if (is_guessed[v] != 0) CHECK(mesh.vertices[v].x() > 0.9);
}

TEST_CASE("Replace patches: a guess without evidence is left alone") {
    Scene scene;
    std::erase_if(scene.capture.views, [](const View& view) { return view.camera.centre().normalized().x() > -0.5; });
    Scene from_behind(scene.capture);
    Mesh mesh = flapped_sphere();
    const Mesh flapped = mesh;
    std::vector<char> is_guessed(mesh.vertices.size());
    for (std::size_t v = 0; v < is_guessed.size(); ++v) is_guessed[v] = is_in_patch(mesh.vertices[v]);
    from_behind.replace_patches(mesh, is_guessed);
    CHECK(mesh.vertices == flapped.vertices);
}
