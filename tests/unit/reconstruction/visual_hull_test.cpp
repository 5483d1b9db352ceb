#include "core/reconstruction/visual_hull.h"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/error.h"
#include "core/mesh/topology.h"
#include "core/reconstruction/iso_surface.h"
#include "core/reconstruction/poisson.h"
#include "core/reconstruction/preview.h"
#include "core/simulation/parametric_meshes.h"
#include "tests/unit/reconstruction/eq_test_scenes.h"
#include "tests/unit/reconstruction/outline_scenes.h"

using namespace anyrate;

namespace {

constexpr double camera_distance = 5.0;
constexpr double pi = 3.14159265358979323846;

// Cameras around the origin, every third one high above.
std::vector<Camera> ring(int n_views, int size = 120) {
    std::vector<Camera> cameras;
    for (int i = 0; i < n_views; ++i) {
        const double azimuth = 2 * pi * i / n_views, elevation = i % 3 == 2 ? 1.0 : 0.2;
        const Vec3 direction(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                             std::sin(elevation));
        cameras.push_back(look_at_origin(camera_distance * direction, size, size, 1.6 * size));
    }
    return cameras;
}

Capture capture_of(const std::vector<Camera>& cameras, const RayTest& body) {
    Capture capture;
    for (const Camera& camera : cameras) capture.views.push_back(outline_view(camera, body));
    return capture;
}

// Edge of a pixel of ring(n, size) at the origin, world units.
double pixel_at_origin(int size = 120) { return camera_distance / (1.6 * size); }

// Where the exact hull of a ball around the origin ends in a direction: every camera's cone touches the ball in the
// circle at angle beta from the camera, and in the plane through camera and direction its outline is the tangent there.
double hull_radius_of_ball(double radius, const std::vector<Camera>& cameras, const Vec3& direction) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Camera& camera : cameras) {
        const double beta = std::acos(radius / camera.centre().norm());
        const double cosine = std::cos(std::acos(direction.dot(camera.centre().normalized())) - beta);
        if (cosine > 0) nearest = std::min(nearest, radius / cosine);
    }
    return nearest;
}

bool same_bytes(const std::vector<OrientedPoint>& a, const std::vector<OrientedPoint>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(OrientedPoint)) == 0;
}

}  // namespace

TEST_CASE("Visual hull: the boundary of a ball's hull is where the tangent cones put it") {
    const auto cameras = ring(12);
    const VisualHull hull = visual_hull(capture_of(cameras, ball(1.0)));
    double sum_error = 0.0, worst_inward = 0.0;
    for (const OrientedPoint& point : hull.points) {
        const double r = point.position.norm();
        sum_error += std::abs(r - hull_radius_of_ball(1.0, cameras, point.position / r));
        worst_inward = std::max(worst_inward, 1.0 - r);
    }
    CHECK(sum_error / static_cast<double>(hull.points.size()) < 0.2 * pixel_at_origin());
    CHECK(worst_inward < 0.6 * pixel_at_origin());
}

TEST_CASE("Visual hull: its points cover the whole boundary and carry its area and volume") {
    const auto cameras = ring(12);
    const VisualHull hull = visual_hull(capture_of(cameras, ball(1.0)));
    // Volume by integrating the exact radius over the directions of a fine icosphere.
    const Mesh directions = icosphere(4);
    double volume = 0.0;
    for (const Vec3& d : directions.vertices)
        volume +=
            std::pow(hull_radius_of_ball(1.0, cameras, d.normalized()), 3) / directions.n_vertices() * 4.0 / 3.0 * pi;
    CHECK(enclosed_volume(hull.points) == doctest::Approx(volume).epsilon(0.02));
    double area = 0.0;
    for (const OrientedPoint& point : hull.points) area += point.area;
    CHECK(area > 4 * pi);
    CHECK(area < 4 * pi * 1.2);
    for (const Vec3& d : icosphere(2).vertices) {
        const Vec3 expected = hull_radius_of_ball(1.0, cameras, d.normalized()) * d.normalized();
        double nearest = 1.0;
        for (const OrientedPoint& point : hull.points) nearest = std::min(nearest, (point.position - expected).norm());
        CHECK(nearest < 1.5 * hull.cell);
    }
}

TEST_CASE("Visual hull: every point is on the border of a silhouette and outside of none") {
    const Capture capture = capture_of(ring(9), ball(1.0));
    const auto sees = [](const View& view, const Vec2& pixel, bool object) {
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const int x = static_cast<int>(std::lround(pixel.x())) + dx,
                          y = static_cast<int>(std::lround(pixel.y())) + dy;
                if (view.mask.contains(x, y) && (view.mask(x, y) != 0) == object) return true;
            }
        return false;
    };
    int n_outside = 0, n_off_border = 0;
    for (const OrientedPoint& point : visual_hull(capture).points) {
        bool on_border = false;
        for (const View& view : capture.views) {
            const Vec2 pixel = view.camera.project(point.position);
            n_outside += !sees(view, pixel, true);
            on_border = on_border || sees(view, pixel, false);
        }
        n_off_border += !on_border;
    }
    CHECK(n_outside == 0);
    CHECK(n_off_border == 0);
}

TEST_CASE("Visual hull: normals are unit vectors and point outwards") {
    for (const OrientedPoint& point : visual_hull(capture_of(ring(12), ball(1.0))).points) {
        CHECK(point.normal.norm() == doctest::Approx(1.0));
        CHECK(point.normal.dot(point.position.normalized()) > 0.7);
    }
}

TEST_CASE("Visual hull: rods down to a width of about one pixel survive in one piece, from end to end") {
    const double pixel = pixel_at_origin(160);
    const std::array ends = {Vec3(0.9, 0.3, 0.5), Vec3(0.05, 0.1, 1.0), Vec3(-0.7, 0.7, 0.02), Vec3(0.4, 0.8, -0.3)};
    for (std::size_t i = 0; i < 12; ++i) {
        const Vec3& end = ends[i % ends.size()];
        const double width_px = std::array{1.2, 2.0, 3.2}[i / ends.size()];
        CAPTURE(i);
        const VisualHull hull = visual_hull(capture_of(ring(12, 160), rod(-end, end, 0.5 * width_px * pixel)));
        const Mesh mesh = iso_surface(poisson_field(hull.points, {.spacing = hull.cell}));
        CHECK(measure_topology(mesh).n_components == 1);
        double first = 0.0, last = 0.0;
        for (const Vec3& v : mesh.vertices) {
            first = std::min(first, v.dot(end.normalized()));
            last = std::max(last, v.dot(end.normalized()));
        }
        CHECK(first == doctest::Approx(-end.norm()).epsilon(4 * pixel));
        CHECK(last == doctest::Approx(end.norm()).epsilon(4 * pixel));
    }
}

TEST_CASE("Visual hull: a column of wrong mask pixels takes nothing away") {
    Capture capture = capture_of(ring(12), ball(1.0));
    const double volume = enclosed_volume(visual_hull(capture).points);
    MaskImage& mask = capture.views[3].mask;
    for (int y = 0; y < mask.height; ++y)
        for (int x : {50, 51}) mask(x, y) = 0;
    CHECK(enclosed_volume(visual_hull(capture).points) == doctest::Approx(volume).epsilon(0.005));
}

TEST_CASE("Visual hull: the world's scale and origin do not matter") {
    const auto cameras = ring(9, 80);
    const VisualHull hull = visual_hull(capture_of(cameras, ball(1.0)));
    for (const double scale : {1e-3, 1.0, 1e3})
        for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(1000, -2000, 500)}) {
            CAPTURE(scale);
            const Vec3 origin = scale * offset;
            Capture capture = capture_of(cameras, ball(1.0));
            for (View& view : capture.views) view.camera = moved(view.camera, scale, origin);
            const VisualHull same = visual_hull(capture);
            CHECK(same.cell == doctest::Approx(scale * hull.cell));
            CHECK(((same.lower - origin) / scale - hull.lower).norm() < 0.1 * hull.cell);
            CHECK(((same.upper - origin) / scale - hull.upper).norm() < 0.1 * hull.cell);
            CHECK(enclosed_volume(same.points) / std::pow(scale, 3) ==
                  doctest::Approx(enclosed_volume(hull.points)).epsilon(1e-3));
        }
}

TEST_CASE("Visual hull: views that see only a part do not cut off the rest") {
    auto cameras = ring(9);
    const double volume = enclosed_volume(visual_hull(capture_of(cameras, ball(1.0))).points);
    // Close-ups: the left third of the image of three more views, whose frame cuts the ball.
    for (int i = 0; i < 3; ++i) {
        cameras.push_back(
            look_at_origin(Vec3(4.5 * std::cos(2.0 * i + 0.3), 4.5 * std::sin(2.0 * i + 0.3), 2), 160, 160, 256));
        cameras.back().width = 70;
    }
    const double with_parts = enclosed_volume(visual_hull(capture_of(cameras, ball(1.0))).points);
    CHECK(with_parts <= volume * 1.001);
    CHECK(with_parts > 4.0 / 3.0 * pi * 0.99);
}

TEST_CASE("Visual hull: a view of a single pixel does no harm") {
    auto cameras = ring(9);
    const double volume = enclosed_volume(visual_hull(capture_of(cameras, ball(1.0))).points);
    cameras.push_back(look_at_origin(Vec3(0, 4, 3), 1, 1, 100));
    CHECK(enclosed_volume(visual_hull(capture_of(cameras, ball(1.0))).points) == doctest::Approx(volume).epsilon(0.01));
}

TEST_CASE("Visual hull: without any complete view the hull is still bounded and keeps the object") {
    auto cameras = ring(12);
    for (Camera& camera : cameras) camera.height = 70;  // the frame cuts off the ball's lower part
    const VisualHull hull = visual_hull(capture_of(cameras, ball(1.0)));
    CHECK(hull.upper.z() == doctest::Approx(1.0).epsilon(0.2));
    CHECK((hull.upper - hull.lower).maxCoeff() < 4.0);
    CHECK(hull.lower.z() < 0.0);
}

// A ring of close-ups that are level: the images show the upper part of the ball only, but for some that show the
// lower part only.
VisualHull hull_of_halves(int n_views, std::initializer_list<int> lower_ones) {
    std::vector<Camera> cameras;
    for (int i = 0; i < n_views; ++i) {
        const double azimuth = 2 * pi * i / n_views;
        cameras.push_back(
            look_at_origin(camera_distance * Vec3(std::cos(azimuth), std::sin(azimuth), 0), 120, 75, 192));
        const bool is_lower = std::ranges::find(lower_ones, i) != lower_ones.end();
        cameras.back().K(1, 2) = is_lower ? 15 : 60;
    }
    return visual_hull(capture_of(cameras, ball(1.0)));
}

TEST_CASE("Visual hull: three views that look across each other are enough to show a part") {
    CHECK(hull_of_halves(24, {0, 6, 12}).lower.z() == doctest::Approx(-1.0).epsilon(0.1));
}

TEST_CASE("Visual hull: three neighbours among many incomplete views are not enough") {
    // The others' images end 14 pixels below the ball's middle.
    CHECK(hull_of_halves(24, {0, 1, 2}).lower.z() > -0.7);
}

TEST_CASE("Visual hull: max_depth bounds the number of cells") {
    const VisualHull hull = visual_hull(capture_of(ring(9), ball(1.0)), {.pixels_per_cell = 0.1, .max_depth = 5});
    CHECK((hull.upper - hull.lower).maxCoeff() <= 32 * hull.cell);
    CHECK(enclosed_volume(hull.points) == doctest::Approx(4.0 / 3.0 * pi).epsilon(0.15));
}

TEST_CASE("Visual hull: silhouettes without a common inside are refused") {
    Capture capture = capture_of(ring(9), ball(1.0));
    SUBCASE("an empty mask") { capture.views[4].mask = MaskImage(120, 120); }
    SUBCASE("a mask of something else") {
        capture.views[4] = outline_view(capture.views[4].camera, ball(0.2, Vec3(0, 0, 1.4)));
    }
    CHECK_THROWS_AS(visual_hull(capture), InputError);
}

TEST_CASE("Visual hull: one and two threads give the same bytes") {
    const Capture capture = capture_of(ring(9), ball(1.0));
    const auto with_threads = [&](std::size_t n) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, n);
        return visual_hull(capture).points;
    };
    CHECK(same_bytes(with_threads(1), with_threads(2)));
}

TEST_CASE("Preview: a small closed mesh near the hull") {
    const auto cameras = ring(12);
    const Mesh mesh = preview_mesh(visual_hull(capture_of(cameras, ball(1.0))));
    const Topology topology = measure_topology(mesh);
    CHECK(topology.is_closed_manifold());
    CHECK(topology.n_components == 1);
    CHECK(topology.euler == 2);
    CHECK(mesh.n_vertices() > 1000);
    CHECK(mesh.n_vertices() < 1600);
    for (const Vec3& v : mesh.vertices)
        CHECK(std::abs(v.norm() - hull_radius_of_ball(1.0, cameras, v.normalized())) < 2.0 / 40);
}
