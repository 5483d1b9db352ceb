#include "core/simulation/simulate.h"

#include <doctest/doctest.h>

#include <tbb/global_control.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/error.h"
#include "core/mesh/topology.h"
#include "tests/scenes.h"

namespace anyrate {
namespace {

const SimulateOptions small{.n_views = 3, .width = 64, .height = 48, .noise = 1.0, .seed = 1, .supersampling = 2};

bool same_bytes(const View& a, const View& b) {
    return a.name == b.name && a.image.pixels == b.image.pixels && a.mask.pixels == b.mask.pixels &&
           a.camera.K == b.camera.K && a.camera.R == b.camera.R && a.camera.t == b.camera.t;
}
bool same_bytes(const Capture& a, const Capture& b) {
    return std::equal(a.views.begin(), a.views.end(), b.views.begin(), b.views.end(),
                      [](const View& u, const View& v) { return same_bytes(u, v); });
}

/// Grey level at a pixel position, interpolated.
double grey(const ColourImage& image, const Vec2& at) {
    const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
    const double u = at.x() - x, v = at.y() - y;
    const auto level = [&](int dx, int dy) {
        const Rgb8 pixel = image(x + dx, y + dy);
        return (pixel.r + pixel.g + pixel.b) / 3.0;
    };
    return (1 - v) * ((1 - u) * level(0, 0) + u * level(1, 0)) + v * ((1 - u) * level(0, 1) + u * level(1, 1));
}

std::string message_of(const auto& action) {
    try {
        action();
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

}  // namespace

TEST_CASE("Simulate: the masks of the sphere are its analytic silhouette within a pixel") {
    for (const View& view : sphere_capture(4, 160).views) {
        const Mat3 ray_from_pixel = view.camera.R.transpose() * view.camera.K.inverse();
        const double pixel_on_sphere = view.camera.centre().norm() / view.camera.K(0, 0);
        int n_wrong = 0;
        for (int y = 0; y < view.mask.height; ++y) {
            for (int x = 0; x < view.mask.width; ++x) {
                const double miss = view.camera.centre().cross((ray_from_pixel * Vec3(x, y, 1)).normalized()).norm();
                const bool masked = view.mask(x, y) != 0;
                n_wrong += (miss < 1 - pixel_on_sphere && !masked) || (miss > 1 + pixel_on_sphere && masked);
            }
        }
        CHECK(n_wrong == 0);
    }
}

TEST_CASE("Simulate: a surface point has the same colour in every view that faces it") {
    const Simulation simulation = simulate_scene(
        "sphere", {.n_views = 10, .width = 160, .height = 120, .noise = 0, .seed = 1, .supersampling = 3});
    double same_point = 0, other_point = 0;
    int n = 0;
    const auto& vertices = simulation.ground_truth.vertices;
    for (std::size_t k = 0; k + 1 < simulation.capture.views.size(); ++k) {
        const View &a = simulation.capture.views[k], &b = simulation.capture.views[k + 1];
        for (std::size_t i = 0; i < vertices.size(); i += 7) {
            const auto faces = [&](const View& view) {
                return vertices[i].dot((view.camera.centre() - vertices[i]).normalized()) > 0.7;
            };
            if (!faces(a) || !faces(b)) continue;
            const double level = grey(a.image, a.camera.project(vertices[i]));
            same_point += std::abs(level - grey(b.image, b.camera.project(vertices[i])));
            other_point += std::abs(level - grey(b.image, b.camera.project(vertices[i]) + Vec2(11, 7)));
            ++n;
        }
    }
    CHECK(n > 500);
    CHECK(same_point / n < 5);
    CHECK(other_point / n > 4 * same_point / n);  // and the texture is strong enough to tell points apart
}

TEST_CASE("Simulate: one thread and two give the same bytes") {
    const auto with_threads = [](std::size_t n) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, n);
        return simulate_scene("dish", small);
    };
    const Simulation one = with_threads(1), two = with_threads(2);
    CHECK(same_bytes(one.capture, two.capture));
    CHECK(one.ground_truth.vertices == two.ground_truth.vertices);
    CHECK(one.ground_truth.triangles == two.ground_truth.triangles);
}

TEST_CASE("Simulate: the same seed gives the same bytes, another seed other noise and other camera places") {
    SimulateOptions other = small;
    other.seed = 2;
    const Capture first = simulate_scene("sphere", small).capture, again = simulate_scene("sphere", small).capture,
                  different = simulate_scene("sphere", other).capture;
    CHECK(same_bytes(first, again));
    CHECK(first.views[0].image.pixels != different.views[0].image.pixels);
    CHECK(first.views[0].camera.R != different.views[0].camera.R);
}

TEST_CASE("Simulate: the surface of every scene is a closed manifold of its genus, and in front of every camera") {
    const std::map<std::string, int> genus{{"vessel", 2}, {"dish", 0}, {"sphere", 0}, {"torus", 1}};
    REQUIRE(scene_names().front() == "vessel");
    REQUIRE(scene_names().size() == genus.size());
    for (const std::string& name : scene_names()) {
        CAPTURE(name);
        const Simulation simulation = simulate_scene(name, small);
        const Topology topology = measure_topology(simulation.ground_truth);
        CHECK(topology.is_closed_manifold());
        CHECK(topology.n_components == 1);
        CHECK(topology.n_vertices - topology.n_edges + topology.n_faces == 2 - 2 * genus.at(name));
        REQUIRE(simulation.capture.views.size() == 3);
        for (const View& view : simulation.capture.views) {
            CHECK(std::all_of(simulation.ground_truth.vertices.begin(), simulation.ground_truth.vertices.end(),
                              [&](const Vec3& vertex) { return view.camera.cam_from_world(vertex).z() > 0; }));
            CHECK(std::any_of(view.mask.pixels.begin(), view.mask.pixels.end(), [](auto pixel) { return pixel != 0; }));
        }
    }
}

TEST_CASE("Simulate: an unknown scene is an input error that names the known ones") {
    const std::string message = message_of([] { simulate_scene("teapot"); });
    CHECK(message.find("teapot") != std::string::npos);
    for (const std::string& name : scene_names()) CHECK(message.find(name) != std::string::npos);
}

TEST_CASE("Simulate: options that make no capture are input errors") {
    for (const SimulateOptions& options :
         {SimulateOptions{.n_views = 2}, SimulateOptions{.width = 0}, SimulateOptions{.height = -5},
          SimulateOptions{.noise = -1}, SimulateOptions{.supersampling = 0}}) {
        CHECK_THROWS_AS(simulate_scene("sphere", options), InputError);
    }
}

TEST_CASE("Simulate: a closed mesh of any size and place is photographed, and is its own ground truth") {
    Mesh cube = cube_surface(4);
    for (Vec3& vertex : cube.vertices) vertex = 1000 * vertex + Vec3(5000, -3000, 200);
    const Simulation simulation = simulate_mesh(cube, small);
    CHECK(simulation.ground_truth.triangles == cube.triangles);
    CHECK(simulation.ground_truth.vertices == cube.vertices);
    for (const View& view : simulation.capture.views) {
        const auto covered = std::count(view.mask.pixels.begin(), view.mask.pixels.end(), 255);
        CHECK(covered > 64 * 48 / 4);
    }
}

TEST_CASE("Simulate: a mesh with a hole is an input error that counts the open edges") {
    Mesh open = icosphere(2);
    open.triangles.pop_back();
    CHECK(message_of([&] { simulate_mesh(open, small); }).find("3 open") != std::string::npos);
    CHECK_THROWS_AS(simulate_mesh(Mesh{}, small), InputError);
}

}  // namespace anyrate
