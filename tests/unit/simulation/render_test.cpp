#include "core/simulation/render.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>

#include "core/mesh/normals.h"
#include "core/simulation/ring_cameras.h"
#include "core/simulation/visible_surface.h"
#include "tests/scenes.h"

namespace anyrate {
namespace {

Camera some_camera(const Mesh& mesh) {
    return ring_cameras(mesh.vertices, {.n_views = 3, .width = 160, .height = 120}).front();
}

/// Distance from the origin to the ray through a pixel position.
double miss_distance(const Camera& camera, const Vec3& position) {
    const Vec3 direction = (camera.R.transpose() * camera.K.inverse() * position).normalized();
    return camera.centre().cross(direction).norm();
}

Model with_appearance(Mesh mesh, Appearance appearance) {
    Model model{.surface = std::move(mesh), .normals = {}, .appearance = std::move(appearance)};
    model.normals = vertex_normals(model.surface);
    return model;
}

}  // namespace

TEST_CASE("Visible band: no ray slips between the triangles of a closed surface") {
    const Mesh sphere = icosphere(4);
    const Camera camera = some_camera(sphere);
    const auto triangles = project_triangles(sphere, camera);
    constexpr int supersampling = 4;
    VisibleBand band(camera.width, 0, camera.height, supersampling);
    for (std::size_t i = 0; i < triangles.size(); ++i) band.draw(triangles[i], static_cast<std::int32_t>(i));
    int n_inside = 0, n_holes = 0, n_beyond = 0;
    for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
            for (int s = 0; s < supersampling * supersampling; ++s) {
                const int i = s % supersampling, j = s / supersampling;
                const double distance = miss_distance(camera, band.position(x, y, i, j));
                const bool hit = band.nearest(x, y, i, j) >= 0;
                n_inside += distance < 0.99;
                n_holes += distance < 0.99 && !hit;
                n_beyond += distance > 1 && hit;
            }
        }
    }
    CHECK(n_inside > 50'000);
    CHECK(n_holes == 0);
    CHECK(n_beyond == 0);
}

TEST_CASE("Visible band: the nearer of two surfaces is seen, whatever the order") {
    Mesh two = icosphere(3, 0.5);
    const int n_first = two.n_faces();
    const Mesh around = icosphere(3, 1.0);
    for (const auto& [a, b, c] : around.triangles) {
        const std::int32_t shift = two.n_vertices();
        two.triangles.push_back({a + shift, b + shift, c + shift});
    }
    two.vertices.insert(two.vertices.end(), around.vertices.begin(), around.vertices.end());
    const Camera camera = some_camera(around);
    const auto triangles = project_triangles(two, camera);
    VisibleBand forwards(camera.width, 0, camera.height, 1), backwards(camera.width, 0, camera.height, 1);
    const auto n = static_cast<std::int32_t>(triangles.size());
    for (std::int32_t i = 0; i < n; ++i) {
        forwards.draw(triangles[static_cast<std::size_t>(i)], i);
        backwards.draw(triangles[static_cast<std::size_t>(n - 1 - i)], n - 1 - i);
    }
    for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
            const std::int32_t nearest = forwards.nearest(x, y, 0, 0);
            REQUIRE(backwards.nearest(x, y, 0, 0) == nearest);
            if (nearest >= 0) REQUIRE(triangles[static_cast<std::size_t>(nearest)].triangle >= n_first);
        }
    }
}

TEST_CASE("Render: a pixel shows the colour of the surface point that projects to it") {
    // A colour linear in space is its own mean over a pixel, so that only the gamma curve and rounding are left.
    const auto colour = [](const Vec3& p) { return Vec3(0.5 + 0.3 * p.x(), 0.5 + 0.3 * p.y(), 0.5 + 0.3 * p.z()); };
    const Model model =
        with_appearance(icosphere(5), [&](const Vec3& point, const Vec3&) -> Vec3 { return colour(point); });
    const Camera camera = some_camera(model.surface);
    const View view = render_view(model, camera, "view", {.supersampling = 3, .noise = 0});
    int n_seen = 0;
    for (const Vec3& vertex : model.surface.vertices) {
        const Vec3 to_camera = (camera.centre() - vertex).normalized();
        if (vertex.dot(to_camera) < 0.5) continue;
        const Vec2 at = camera.project(vertex);
        const auto x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
        if ((at - Vec2(x, y)).norm() > 0.1) continue;  // near a pixel's centre: then the pixel is that point's
        const Vec3 expected = colour(vertex);
        const Rgb8 seen = view.image(x, y);
        CHECK(std::abs(seen.r - to_level(expected.x())) <= 2);
        CHECK(std::abs(seen.g - to_level(expected.y())) <= 2);
        CHECK(std::abs(seen.b - to_level(expected.z())) <= 2);
        ++n_seen;
    }
    CHECK(n_seen > 20);
}

TEST_CASE("Render: the sensor noise has the deviation asked for") {
    const Model model =
        with_appearance(cube_surface(1), [](const Vec3&, const Vec3&) -> Vec3 { return Vec3::Constant(0.5); });
    const Camera camera = some_camera(model.surface);
    const View view = render_view(model, camera, "view", {.supersampling = 1, .noise = 3.0, .seed = 8});
    const double expected = to_level(0.5);
    double squares = 0;
    int n = 0;
    for (int y = 1; y + 1 < camera.height; ++y) {
        for (int x = 1; x + 1 < camera.width; ++x) {
            if (view.mask(x, y) == 0 || view.mask(x - 1, y) == 0 || view.mask(x + 1, y) == 0) continue;
            squares += std::pow(view.image(x, y).g - expected, 2);
            ++n;
        }
    }
    CHECK(std::sqrt(squares / n) == doctest::Approx(3).epsilon(0.05));
}

TEST_CASE("Studio light: between 0 and 1 for every normal, and never dark") {
    for (const Vec3& normal : icosphere(3).vertices) {
        CHECK(studio_light(normal) > 0.2);
        CHECK(studio_light(normal) <= 1);
    }
}

}  // namespace anyrate
