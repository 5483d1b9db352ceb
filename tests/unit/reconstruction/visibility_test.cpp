#include "core/reconstruction/visibility.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

PhotoImages ring_of_views(int n_views, double scale = 1.0, const Vec3& origin = Vec3::Zero()) {
    Capture capture = painted_sphere(n_views, 128, wavy_paint);
    for (View& view : capture.views) {
        // The same pictures of a world that is larger and elsewhere.
        view.camera.t = scale * view.camera.t - view.camera.R * origin;
    }
    return make_photo_images(capture, 2);
}

Mesh join(const Mesh& a, const Mesh& b) {
    Mesh both = a;
    both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (Triangle t : b.triangles) {
        for (std::int32_t& v : t) v += a.n_vertices();
        both.triangles.push_back(t);
    }
    return both;
}

}  // namespace

TEST_CASE("Visibility: a convex surface is seen exactly by the views its faces look at") {
    const PhotoImages images = ring_of_views(6);
    const Mesh mesh = icosphere(3);
    const VisibilityOptions options;
    const Visibility visibility(images, mesh, options);
    for (std::int32_t f = 0; f < mesh.n_faces(); ++f) {
        const Triangle& t = mesh.triangles[static_cast<std::size_t>(f)];
        const Vec3 a = mesh.vertices[static_cast<std::size_t>(t[0])], b = mesh.vertices[static_cast<std::size_t>(t[1])],
                   c = mesh.vertices[static_cast<std::size_t>(t[2])];
        const Vec3 normal = (b - a).cross(c - a).normalized(), centroid = (a + b + c) / 3;
        for (std::int32_t i = 0; i < images.n_views(); ++i) {
            const double cos_theta =
                normal.dot((images.views[static_cast<std::size_t>(i)].centre - centroid).normalized());
            const auto views = visibility.views(f);
            const bool seen = std::any_of(views.begin(), views.end(), [i](const FaceView& v) { return v.view == i; });
            if (cos_theta > options.min_cos + 1e-9) CHECK(seen);
            if (cos_theta < options.min_cos - 1e-9) CHECK_FALSE(seen);
        }
    }
}

TEST_CASE("Visibility: what stands behind something else is not seen, at any scale and place of the world") {
    for (const auto& [scale, origin] :
         {std::pair{1.0, Vec3(0, 0, 0)}, {1e-3, Vec3(5, 0, 0)}, {1e3, Vec3(-7e4, 2e4, 1e3)}}) {
        const PhotoImages images = ring_of_views(4, scale, origin);
        // A small sphere behind a larger one, as view 0 sees them.
        const Vec3 away = -(images.views[0].centre - origin).normalized();
        const Mesh front = icosphere(3, 0.5 * scale, origin);
        const Mesh hidden = icosphere(2, 0.1 * scale, origin + 0.8 * scale * away);
        const Visibility visibility(images, join(front, hidden));
        int n_seen_front = 0;
        for (std::int32_t f = 0; f < front.n_faces() + hidden.n_faces(); ++f)
            for (const FaceView& view : visibility.views(f))
                if (view.view == 0) {
                    CHECK(f < front.n_faces());
                    ++n_seen_front;
                }
        CHECK(n_seen_front > front.n_faces() / 4);
    }
}

TEST_CASE("Visibility: along a contour what lies behind is hidden for one depth pixel, what lies far behind for two") {
    const PhotoImages images = ring_of_views(4);
    const double radius = 0.4;
    const Mesh front = icosphere(4, radius);
    const PhotoLevel& image = images.views[0].levels[0];
    const double distance = images.views[0].centre.norm();
    const Vec2 middle = (image.P * Vec3(0, 0, 0).homogeneous()).hnormalized();
    const double contour_px = images.views[0].focal_px * radius / std::sqrt(distance * distance - radius * radius);
    const auto behind = static_cast<float>(1 / (distance + 1));
    const double never = 1e9;
    const auto part_hidden = [&](int finest_level, double beyond_px, double far_px) {
        VisibilityOptions options;
        options.far_px = far_px;
        options.finest_level = finest_level;
        const Visibility visibility(images, front, options);
        constexpr int n_angles = 360;
        int n_hidden = 0;
        for (int i = 0; i < n_angles; ++i) {
            const double angle = 2 * std::acos(-1.0) * i / n_angles;
            const Vec2 pixel = middle + (contour_px + beyond_px) * Vec2(std::cos(angle), std::sin(angle));
            const Float8 x = Float8{} + static_cast<float>(pixel.x()), y = Float8{} + static_cast<float>(pixel.y());
            Float8 visible;
            visibility.look_at(0, 0, x, y, Float8{} + behind, visible);
            n_hidden += visible[static_cast<std::size_t>(i) % n_lanes] > 0 ? 0 : 1;
        }
        return static_cast<double>(n_hidden) / n_angles;
    };
    const double far_px = VisibilityOptions{}.far_px;
    REQUIRE(images.n_levels() > 1);
    for (const int finest : {0, 1}) {
        CAPTURE(finest);
        const double depth_pixel = std::exp2(finest);
        CHECK(part_hidden(finest, -0.5 * depth_pixel, never) == 1.0);
        CHECK(part_hidden(finest, 0.25 * depth_pixel, never) > 0.8);
        CHECK(part_hidden(finest, 1.5 * depth_pixel, never) == 0.0);  // beyond the diagonal of a pixel
        CHECK(part_hidden(finest, 1.25 * depth_pixel, far_px) > 0.8);
        CHECK(part_hidden(finest, 3 * depth_pixel, far_px) == 0.0);  // beyond the diagonal of two pixels
    }
    CHECK(part_hidden(1, 1.0, never) > part_hidden(0, 1.0, never));
}

TEST_CASE("Visibility: of the faces asked for it says what it says with all of them") {
    const PhotoImages images = ring_of_views(6);
    // The bulge of a bent torus hides parts of it from the views beside.
    const Mesh mesh = join(torus(0.6, 0.25, 60, 30), icosphere(3, 0.2, Vec3(0.9, 0.2, 0.1)));
    const Visibility whole(images, mesh);
    for (const auto& range : {std::pair{0, 40}, {700, 1500}, {mesh.n_faces() - 1200, mesh.n_faces()}}) {
        CAPTURE(range.first);
        std::vector<std::int32_t> faces;
        for (std::int32_t f = range.first; f < range.second; f += 3) faces.push_back(f);
        const Visibility part(images, mesh, {}, faces);
        int n_hidden = 0, n_visible = 0;
        for (const std::int32_t f : faces) {
            const auto views = part.views(f), expected = whole.views(f);
            REQUIRE(views.size() == expected.size());
            CHECK(part.mean_area_px(f) == whole.mean_area_px(f));
            CHECK(part.pixel_size(f) == whole.pixel_size(f));
            const Triangle& t = mesh.triangles[static_cast<std::size_t>(f)];
            for (std::size_t i = 0; i < views.size(); ++i) {
                CHECK(views[i].view == expected[i].view);
                CHECK(views[i].whole == expected[i].whole);
                // Around the first corner, as far as it reaches.
                const PhotoLevel& image = images.views[static_cast<std::size_t>(views[i].view)].levels[0];
                const Vec3 x = image.P * mesh.vertices[static_cast<std::size_t>(t[0])].homogeneous();
                const float reach =
                    Visibility::reach_px *
                    std::exp2(static_cast<float>(depth_map_level(images, VisibilityOptions{}.finest_level)));
                const Float8 u =
                    Float8{-1, -0.5F, 0, 0.25F, 0.5F, 0.8F, 1, 0.1F} * reach + static_cast<float>(x.x() / x.z());
                const Float8 v =
                    Float8{1, 0.3F, 0, -0.6F, -1, 0.4F, 1, -0.2F} * reach + static_cast<float>(x.y() / x.z());
                Float8 visible, also_visible;
                const Float8 depth = Float8{} + static_cast<float>(1 / x.z());
                part.look_at(f, views[i].view, u, v, depth, visible);
                whole.look_at(f, views[i].view, u, v, depth, also_visible);
                for (std::size_t lane = 0; lane < n_lanes; ++lane) {
                    const bool in_part = visible[lane] > 0, in_whole = also_visible[lane] > 0;
                    CHECK(in_part == in_whole);
                    ++(in_part ? n_visible : n_hidden);
                }
            }
        }
        CHECK(n_visible > 0);
        CHECK(n_hidden > 0);
    }
}
