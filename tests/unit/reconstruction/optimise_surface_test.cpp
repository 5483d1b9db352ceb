#include "core/reconstruction/optimise_surface.h"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

struct Scene {
    Capture capture = painted_sphere(12, 160, wavy_paint);
    PhotoImages images = make_photo_images(capture, 3);
    Silhouettes silhouettes{capture};
    std::unique_ptr<PhotoBackend> backend = make_cpu_backend(images);

    void optimise(Mesh& mesh, const OptimiseOptions& options = {}, std::span<const std::int32_t> active = {}) {
        optimise_surface(*backend, silhouettes, mesh.vertices, mesh.triangles, active, {}, options);
    }
};

double mean_error(const Mesh& mesh) {
    double sum = 0;
    int n = 0;
    for (const Vec3& v : mesh.vertices)
        if (std::abs(v.z()) < 0.6) {  // what the ring of cameras sees well
            sum += std::abs(v.norm() - 1.0);
            ++n;
        }
    return sum / n;
}

}  // namespace

TEST_CASE("Optimise: a surface that starts on the truth stays there") {
    Scene scene;
    Mesh mesh = icosphere(4);
    scene.optimise(mesh);
    // A pixel is 1/62 of the radius; the chords of the icosphere are within 0.002 of the sphere.
    CHECK(mean_error(mesh) < 0.1 / 62);
}

TEST_CASE("Optimise: a surface two pixels off comes back within a fifth of a pixel") {
    Scene scene;
    for (double radius : {0.97, 1.03}) {
        Mesh mesh = icosphere(3, radius);
        for (int level : {1, 0}) scene.optimise(mesh, {.level = level});
        CHECK(mean_error(mesh) < 0.2 / 62);
    }
}

TEST_CASE("Optimise: vertices that are not active do not move") {
    Scene scene;
    Mesh mesh = icosphere(3, 0.98);
    const std::vector<Vec3> before = mesh.vertices;
    const std::vector<std::int32_t> active{3, 50, 51, 200};
    scene.optimise(mesh, {.rounds = 1}, active);
    for (std::int32_t v = 0; v < mesh.n_vertices(); ++v)
        if (std::find(active.begin(), active.end(), v) == active.end())
            CHECK(mesh.vertices[static_cast<std::size_t>(v)] == before[static_cast<std::size_t>(v)]);
}

TEST_CASE("Optimise: on images without texture the silhouettes carry the surface and nothing explodes") {
    Scene scene;
    scene.capture = painted_sphere(12, 160, [](const Vec3&) { return Vec3(100, 100, 100); });
    scene.images = make_photo_images(scene.capture, 3);
    scene.silhouettes = Silhouettes(scene.capture);
    Mesh mesh = icosphere(3, 1.02);
    const double before = mean_error(mesh);
    scene.optimise(mesh);
    CHECK(mean_error(mesh) < before);
    for (const Vec3& v : mesh.vertices) CHECK(v.norm() == doctest::Approx(1.0).epsilon(0.05));
}

TEST_CASE("Optimise: where texture is too faint to tell more than noise there are more rounds") {
    /// Ends every round as one that may be followed by another.
    class CountingRounds final : public PhotoBackend {
    public:
        explicit CountingRounds(bool is_faint) : is_faint_(is_faint) {}
        void set_surface(const SurfaceView&, int, double, std::span<const std::int32_t>) override {}
        std::vector<TriangleDistortion> distortions(std::span<const TriangleQuery>) override { return {}; }
        std::vector<TriangleTerms> terms(std::span<const TriangleQuery>,
                                         std::span<const std::array<Vec3, 3>>) override {
            return {};
        }
        RoundOutcome optimise_round(const OptimiseRound&, std::vector<Vec3>&, double damping) override {
            ++n_rounds;
            return {.falls = true, .damping = damping, .is_faint = is_faint_};
        }
        double pixel_size(std::int32_t) const override { return 1; }
        int n_levels() const override { return 1; }
        int n_rounds = 0;

    private:
        bool is_faint_;
    };
    Scene scene;
    const auto n_rounds = [&](bool is_faint) {
        CountingRounds backend(is_faint);
        Mesh mesh = icosphere(1);
        optimise_surface(backend, scene.silhouettes, mesh.vertices, mesh.triangles, {}, {}, {.rounds = 2});
        return backend.n_rounds;
    };
    CHECK(n_rounds(false) == 2);
    CHECK(n_rounds(true) > 2);
}

TEST_CASE("Optimise: what no image shows keeps its ring's shape: a dent goes, the sphere stays round") {
    Scene scene;
    scene.capture.views.resize(2);
    scene.images = make_photo_images(scene.capture, 3);
    scene.silhouettes = Silhouettes(scene.capture);
    Vec3 towards = Vec3::Zero();
    for (const View& view : scene.capture.views) towards += view.camera.centre().normalized();
    Mesh mesh = icosphere(3);
    const auto cosine = [&](const Vec3& v) { return v.normalized().dot(towards.normalized()); };
    const auto dented =
        static_cast<std::size_t>(std::ranges::min_element(mesh.vertices, {}, cosine) - mesh.vertices.begin());
    mesh.vertices[dented] *= 0.95;
    scene.optimise(mesh);
    CHECK(mesh.vertices[dented].norm() > 0.98);
    double sum = 0;
    int n = 0;
    for (const Vec3& v : mesh.vertices)
        if (cosine(v) < -0.5) {
            sum += v.norm();
            ++n;
        }
    REQUIRE(n > 100);
    CHECK(sum / n == doctest::Approx(1).epsilon(0.012));
}

TEST_CASE("Optimise: one and two threads give the same bytes") {
    const auto run = [](std::size_t n_threads) {
        const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, n_threads);
        Scene scene;
        Mesh mesh = icosphere(3, 0.98);
        scene.optimise(mesh, {.rounds = 2});
        return mesh.vertices;
    };
    CHECK(run(1) == run(2));
}

TEST_CASE("Silhouette: the distance to a half-plane's border is exact, half-way between inside and outside") {
    MaskImage mask(40, 20);
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 17; ++x) mask(x, y) = 255;
    const Image<std::int8_t> distance = silhouette_distance(mask);
    for (int y = 0; y < 20; ++y)
        for (int x = 6; x < 28; ++x) CHECK(distance(x, y) == std::lround(8 * (16.5 - x)));
}

TEST_CASE("Silhouette: the term's gradient is the derivative of its energy") {
    Scene scene;
    Mesh mesh = icosphere(3, 1.01);
    const OneRings rings(mesh);
    const auto normals = vertex_normals(mesh, rings);
    std::vector<std::int32_t> all(mesh.vertices.size());
    for (std::size_t v = 0; v < all.size(); ++v) all[v] = static_cast<std::int32_t>(v);
    scene.silhouettes.look(mesh);
    const auto terms = scene.silhouettes.terms(mesh, rings, normals, all, 3.0);
    constexpr double h = 1e-4;
    double error = 0, size = 0;
    for (std::size_t v = 0; v < all.size(); ++v) {
        if (terms[v].energy == 0) continue;
        Mesh forward = mesh, backward = mesh;
        forward.vertices[v] += h * normals[v];
        backward.vertices[v] -= h * normals[v];
        const std::int32_t one[] = {all[v]};
        const double numeric = (scene.silhouettes.terms(forward, rings, normals, one, 3.0)[0].energy -
                                scene.silhouettes.terms(backward, rings, normals, one, 3.0)[0].energy) /
                               (2 * h);
        error += std::abs(numeric - terms[v].gradient);
        size += std::abs(numeric);
    }
    REQUIRE(size > 0);
    CHECK(error < 0.05 * size);
}
