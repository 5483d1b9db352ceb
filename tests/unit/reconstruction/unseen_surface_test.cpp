#include "core/reconstruction/unseen_surface.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/simulation/parametric_meshes.h"

using namespace anyrate;

namespace {

/// An image of 100 x 100 pixels with the origin in its middle.
PhotoLevel image_of_origin(const Vec3& centre, double focal_px) {
    const Vec3 forward = -centre.normalized(), right = forward.cross(Vec3::UnitZ()).normalized();
    Mat34 pose;
    pose.leftCols<3>() << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    pose.col(3) = -pose.leftCols<3>() * centre;
    Mat3 K;
    K << focal_px, 0, 50, 0, focal_px, 50, 0, 0, 1;
    return {.width = 100, .height = 100, .P = K * pose, .rgba = {}};
}

/// Views on a circle above the origin; of a sphere of radius 1 they contain all with a focal length of 100 pixels.
PhotoImages ring_of_views(double height, double focal_px = 100) {
    constexpr int n_views = 24;
    PhotoImages images;
    for (int i = 0; i < n_views; ++i) {
        const double angle = 2 * std::numbers::pi * i / n_views;
        PhotoView view;
        view.centre = Vec3(5 * std::cos(angle), 5 * std::sin(angle), height);
        view.levels.push_back(image_of_origin(view.centre, focal_px));
        images.views.push_back(view);
    }
    return images;
}

/// A sphere with the cone that its silhouettes' hull would have below it, down to the apex at z = -1.4.
Mesh sphere_on_cone() {
    Mesh mesh = icosphere(4);
    const double apex = -1.4, tangent = -1 / apex;  // of height, where the cone touches the sphere: z = -1 / 1.4
    for (Vec3& v : mesh.vertices)
        if (v.z() < -tangent) {
            const double part = (-tangent - v.z()) / (1 - tangent);  // from the circle of contact to the apex
            const double radius = (1 - part) * std::sqrt(1 - tangent * tangent);
            const double around = std::hypot(v.x(), v.y());
            const double x = around > 0 ? v.x() / around : 0, y = around > 0 ? v.y() / around : 0;
            v = Vec3(radius * x, radius * y, -tangent + part * (apex + tangent));
        }
    return mesh;
}

}  // namespace

TEST_CASE("Unseen surface: the cone below a sphere, of views from above, and nothing else") {
    const Mesh mesh = sphere_on_cone();
    const std::vector<char> unseen = unseen_vertices(mesh, ring_of_views(3.0));
    for (std::size_t v = 0; v < unseen.size(); ++v) {
        if (mesh.vertices[v].z() < -0.8) CHECK(unseen[v] == 1);
        if (mesh.vertices[v].z() > -0.4) CHECK(unseen[v] == 0);
    }
}

TEST_CASE("Unseen surface: views all around leave nothing unseen") {
    PhotoImages images = ring_of_views(3.0);
    const PhotoImages below = ring_of_views(-3.0);
    images.views.insert(images.views.end(), below.views.begin(), below.views.end());
    const std::vector<char> unseen = unseen_vertices(icosphere(3), images);
    CHECK(unseen == std::vector<char>(unseen.size(), 0));
}

TEST_CASE("Unseen surface: a part of less than the least share of the area is left alone") {
    const Mesh mesh = sphere_on_cone();
    const std::vector<char> unseen = unseen_vertices(mesh, ring_of_views(3.0), {.least_share = 0.5});
    CHECK(unseen == std::vector<char>(unseen.size(), 0));
}

TEST_CASE("Unseen surface: what lies beyond the images") {
    const Mesh mesh = icosphere(4);
    const std::vector<char> unseen =
        unseen_vertices(mesh, ring_of_views(0.0, 400));  // 0.6 to each side, where it shows
    for (std::size_t v = 0; v < unseen.size(); ++v) {
        if (std::abs(mesh.vertices[v].z()) > 0.75) CHECK(unseen[v] == 1);
        if (std::abs(mesh.vertices[v].z()) < 0.3) CHECK(unseen[v] == 0);
    }
}

TEST_CASE("Unseen surface: points that too few views look at are dropped") {
    const std::vector<OrientedPoint> points = {{Vec3(0, 0, 1), Vec3(0, 0, 1), 1}, {Vec3(0, 0, -1), Vec3(0, 0, -1), 1}};
    const std::vector<OrientedPoint> seen = without_unseen(points, ring_of_views(3.0));
    REQUIRE(seen.size() == 1);
    CHECK(seen.front().position == points.front().position);
}
