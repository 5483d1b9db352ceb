#include "core/reconstruction/confirm_guesses.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <random>

#include <Eigen/Geometry>

#include "core/mesh/subdivide.h"
#include "core/reconstruction/optimise_surface.h"
#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

struct Scene {
    Capture capture = painted_sphere(12, 160, wavy_paint);
    PhotoImages images;
    Silhouettes silhouettes;
    std::unique_ptr<PhotoBackend> backend;

    explicit Scene(const std::function<bool(const View&)>& has_view = [](const View&) { return true; })
        : images((std::erase_if(capture.views, std::not_fn(has_view)), make_photo_images(capture, 3))),
          silhouettes(capture),
          backend(make_cpu_backend(images)) {}
};

bool is_in_patch(const Vec3& v) { return v.normalized().x() > 0.95; }

// A unit sphere whose patch around +x stands at another radius.
Mesh dented_sphere(double radius_of_patch) {
    Mesh mesh = icosphere(3);
    for (Vec3& v : mesh.vertices)
        if (is_in_patch(v)) v *= radius_of_patch;
    return mesh;
}

GuessedSurface patch_of(const Mesh& mesh) {
    std::vector<OrientedPoint> points;
    for (const Vec3& v : mesh.vertices)
        if (is_in_patch(v)) points.push_back({v, v.normalized(), 0.0});
    return GuessedSurface(points, 0.01);
}

int n_guessed(const GuessedSurface& guessed, const Mesh& mesh) {
    int n = 0;
    for (const char flag : guessed.vertices(mesh)) n += flag;
    return n;
}

}  // namespace

TEST_CASE("Confirm guesses: where the photographs agree the guess ends, on the surface they show") {
    Scene scene;
    Mesh mesh = dented_sphere(0.98);
    const GuessedSurface guessed = patch_of(mesh);
    REQUIRE(n_guessed(guessed, mesh) > 5);
    const GuessedSurface left = confirm_guesses(*scene.backend, scene.silhouettes, guessed, mesh);
    CHECK(n_guessed(left, mesh) == 0);
    for (const Vec3& v : mesh.vertices)
        if (is_in_patch(v)) CHECK(std::abs(v.norm() - 1) < 0.01);
}

TEST_CASE("Confirm guesses: what no photograph shows stays a guess and continues its surroundings") {
    Scene scene([](const View& view) { return view.camera.centre().normalized().x() < 0.1; });
    Mesh mesh = dented_sphere(0.8);
    const GuessedSurface left = confirm_guesses(*scene.backend, scene.silhouettes, patch_of(mesh), mesh);
    CHECK(n_guessed(left, mesh) > 5);
    for (const Vec3& v : mesh.vertices)
        if (is_in_patch(v)) CHECK(std::abs(v.norm() - 1) < 0.05);
}

TEST_CASE("Confirm guesses: what no photograph shows beside a guess is one as well") {
    Scene scene([](const View& view) { return view.camera.centre().normalized().x() < 0.1; });
    Mesh mesh = icosphere(3);
    std::vector<OrientedPoint> middle;
    for (Vec3& v : mesh.vertices) {
        const bool is_middle = v.x() > 0.98;
        if (v.x() > 0.87) v *= 0.8;  // three rings more than the middle
        if (is_middle) middle.push_back({v, v.normalized(), 0.0});
    }
    confirm_guesses(*scene.backend, scene.silhouettes, GuessedSurface(middle, 0.01), mesh);
    for (const Vec3& v : mesh.vertices)
        if (v.normalized().x() > 0.85) CHECK(std::abs(v.norm() - 1) < 0.06);
}

TEST_CASE("Confirm guesses: a dent that the photographs contradict goes, though it was no guess") {
    Scene scene;
    Mesh mesh = dented_sphere(0.8);
    confirm_guesses(*scene.backend, scene.silhouettes, {}, mesh);
    for (const Vec3& v : mesh.vertices)
        if (is_in_patch(v)) CHECK(std::abs(v.norm() - 1) < 0.02);
}

TEST_CASE("Confirm guesses: where every photograph shows something else, what was no guess becomes one") {
    Scene scene;
    for (std::size_t i = 0; i < scene.capture.views.size(); ++i) {
        const auto of_this_view = [i](const Vec3& p) {
            const Vec3 turned = Eigen::AngleAxisd(1.7 * static_cast<double>(i), Vec3::UnitX()) * Vec3(2 * p);
            return is_in_patch(p) ? wavy_paint(turned) : wavy_paint(p);
        };
        scene.capture.views[i].image = painted_sphere(12, 160, of_this_view).views[i].image;
    }
    scene.images = make_photo_images(scene.capture, 3);
    Mesh mesh = icosphere(3);
    const GuessedSurface left = confirm_guesses(*scene.backend, scene.silhouettes, {}, mesh);
    const std::vector<char> is_guessed = left.vertices(mesh);
    int n_in_patch = 0;
    for (std::size_t v = 0; v < is_guessed.size(); ++v) {
        if (is_guessed[v] == 0) continue;
        n_in_patch += is_in_patch(mesh.vertices[v]) ? 1 : 0;
        CHECK(mesh.vertices[v].normalized().x() > 0.75);  // the patch and what touches it
        CHECK(std::abs(mesh.vertices[v].norm() - 1) < 0.05);
    }
    CHECK(n_in_patch > 5);
}

TEST_CASE("Confirm guesses: a lump that the photographs contradict, and would not see without it, becomes a guess") {
    // No view is on the side of +x: the patch is out of sight but on a lump, which stands before a noisy background.
    Scene scene([](const View& view) { return view.camera.centre().normalized().x() < 0.1; });
    std::mt19937 noise(1);
    for (View& view : scene.capture.views)
        for (std::size_t i = 0; i < view.mask.pixels.size(); ++i) {
            if (view.mask.pixels[i] != 0) continue;
            view.mask.pixels[i] = 255;
            const auto grey = static_cast<std::uint8_t>(noise() & 255);
            view.image.pixels[i] = {grey, grey, grey};
        }
    scene.images = make_photo_images(scene.capture, 3);
    scene.silhouettes = Silhouettes(scene.capture);
    Mesh mesh = icosphere(3);
    for (Vec3& v : mesh.vertices)
        if (is_in_patch(v)) v *= 1 + 14 * (v.x() - 0.95);  // a cone
    const GuessedSurface left = confirm_guesses(*scene.backend, scene.silhouettes, {}, mesh);
    CHECK(n_guessed(left, mesh) > 5);
}

TEST_CASE("Confirm guesses: a guess reaches to its border and no farther, on a subdivided mesh too") {
    Scene scene;
    Mesh mesh = icosphere(3);
    const std::vector<char> is_guessed = patch_of(mesh).vertices(mesh);
    const GuessedSurface left = confirm_guesses(*scene.backend, scene.silhouettes, patch_of(mesh), mesh, {.passes = 0});
    CHECK(left.vertices(mesh) == is_guessed);

    const Mesh fine = subdivide(mesh);
    const OneRings rings(fine);
    const std::vector<char> is_guessed_there = left.vertices(fine);
    for (std::size_t v = 0; v < fine.vertices.size(); ++v) {
        if (v < is_guessed.size()) {
            CHECK(is_guessed_there[v] == is_guessed[v]);
            continue;
        }
        int n_ends = 0;  // of the edge that the vertex is the middle of
        for (const std::int32_t w : rings.neighbours(static_cast<std::int32_t>(v)))
            if (static_cast<std::size_t>(w) < is_guessed.size()) n_ends += is_guessed[static_cast<std::size_t>(w)];
        if (n_ends == 2) CHECK(is_guessed_there[v] == 1);
        if (n_ends == 0) CHECK(is_guessed_there[v] == 0);
    }
}

TEST_CASE("Confirm guesses: nothing moves where the photographs agree and nothing was guessed") {
    Scene scene;
    Mesh mesh = icosphere(3);
    const Mesh before = mesh;
    confirm_guesses(*scene.backend, scene.silhouettes, {}, mesh);
    CHECK(mesh.vertices == before.vertices);
}

TEST_CASE("Optimise: guessed vertices stay where they are") {
    Scene scene;
    Mesh mesh = dented_sphere(0.6);
    const Mesh before = mesh;
    const std::vector<char> is_guessed = patch_of(mesh).vertices(mesh);
    optimise_surface(*scene.backend, scene.silhouettes, mesh.vertices, mesh.triangles, {}, is_guessed, {.rounds = 1});
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        if (is_guessed[v] != 0) CHECK(mesh.vertices[v] == before.vertices[v]);
}
