#include "core/reconstruction/inverse_depth.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

PhotoImages ring_of_views() { return make_photo_images(painted_sphere(3, 128, wavy_paint), 2); }

}  // namespace

TEST_CASE("Inverse depth: it is that of the distance along the optical axis") {
    const PhotoImages images = ring_of_views();
    const Image<float> inverse_depth = render_inverse_depth(images.views[0].levels[0], icosphere(5));
    // The ray through the principal point meets the unit sphere one radius before its centre.
    const double distance = images.views[0].centre.norm();
    CHECK(inverse_depth(63, 63) == doctest::Approx(1 / (distance - 1)).epsilon(2e-3));
    CHECK(inverse_depth(0, 0) == 0);
}

TEST_CASE("Inverse depth: every pixel has that of the nearest triangle on its ray") {
    const PhotoImages images = ring_of_views();
    const PhotoLevel& level = images.views[1].levels[1];
    const Mesh mesh = icosphere(2, 0.7, Vec3(0.1, -0.2, 0.3));
    const Image<float> inverse_depth = render_inverse_depth(level, mesh);
    const Mat3 world_from_pixel = level.P.leftCols<3>().inverse();
    int n_covered = 0;
    for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x) {
            // The ray by Moeller and Trumbore's test against every face; its direction has depth 1.
            const Vec3 direction = world_from_pixel * Vec3(x, y, 1);
            double nearest = std::numeric_limits<double>::infinity(), margin = nearest;
            for (const Triangle& t : mesh.triangles) {
                const auto vertex = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
                const Vec3 e1 = vertex(1) - vertex(0), e2 = vertex(2) - vertex(0), p = direction.cross(e2);
                const Vec3 s = images.views[1].centre - vertex(0), q = s.cross(e1);
                const double det = e1.dot(p), u = s.dot(p) / det, v = direction.dot(q) / det, z = e2.dot(q) / det;
                const double inside = std::min({u, v, 1 - u - v});
                margin = std::min(margin, std::abs(inside));
                if (inside >= 0 && z > 0) nearest = std::min(nearest, z);
            }
            if (margin < 1e-3) continue;  // on an edge, where rounding decides
            const double expected = std::isinf(nearest) ? 0.0 : 1 / nearest;
            CHECK(inverse_depth(x, y) == doctest::Approx(expected).epsilon(1e-5));
            n_covered += expected > 0;
        }
    CHECK(n_covered > 100);
}

TEST_CASE("Inverse depth: triangles across the frame fill what the image has of them") {
    const PhotoImages images = ring_of_views();
    const PhotoLevel& level = images.views[0].levels[0];
    const double distance = images.views[0].centre.norm();
    const Image<float> inverse_depth = render_inverse_depth(level, icosphere(4, 0.9 * distance));
    // The camera stands outside of a sphere that fills the image.
    CHECK(std::ranges::all_of(inverse_depth.pixels, [](float d) { return d > 0; }));
}

TEST_CASE("Inverse depth: a part of the image is what the whole image has there, to the bit") {
    const PhotoImages images = ring_of_views();
    const PhotoLevel& level = images.views[2].levels[0];
    // One sphere of small triangles before one whose triangles are larger than the boxes.
    Mesh mesh = icosphere(4, 0.5, 0.4 * images.views[2].centre.normalized());
    const Mesh large = icosphere(0, 1.5);
    for (Triangle t : large.triangles) {
        for (std::int32_t& v : t) v += mesh.n_vertices();
        mesh.triangles.push_back(t);
    }
    mesh.vertices.insert(mesh.vertices.end(), large.vertices.begin(), large.vertices.end());
    const Image<float> whole = render_inverse_depth(level, mesh);
    const std::vector<ScreenVertex> vertices = project(level, mesh);
    const int w = level.width, h = level.height;
    for (const PixelBox& box : {PixelBox{0, 0, w, h}, PixelBox{50, 40, 51, 41}, PixelBox{0, 0, 7, 9},
                                PixelBox{w - 2, h - 3, w, h}, PixelBox{31, 22, 78, 69}}) {
        CAPTURE(box.x0);
        const std::vector<Triangle> near = triangles_at(box, vertices, mesh.triangles);
        for (const std::span<const Triangle> triangles : {std::span<const Triangle>(mesh.triangles), {near}}) {
            const InverseDepthPart part = render_inverse_depth_in(box, w, h, vertices, triangles);
            int n_different = 0;
            for (int y = box.y0; y < box.y1; ++y)
                for (int x = box.x0; x < box.x1; ++x)
                    n_different += part.pixels(x - part.x, y - part.y) != whole(x, y) ? 1 : 0;
            CHECK(n_different == 0);
        }
    }
    const PixelBox around = pixels_around(vertices, w, h);
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x)
            if (x < around.x0 || y < around.y0 || x >= around.x1 || y >= around.y1) CHECK(whole(x, y) == 0);
}

namespace {

Image<float> noise() {
    Image<float> image(19, 7, 0.0F);
    unsigned random = 1;
    for (float& inverse_depth : image.pixels) {
        random = random * 1664525u + 1013904223u;
        inverse_depth = static_cast<float>(random >> 24) / 256;
    }
    return image;
}

}  // namespace

TEST_CASE("Inverse depth: a widened contour hides what lies clearly behind it, one pixel around, and nothing else") {
    InverseDepthPart part{0, 0, noise()};
    const Image<float> before = part.pixels;
    constexpr float far_part = 0.75F;
    widen_far_contours(part, far_part);
    for (int y = 0; y < before.height; ++y)
        for (int x = 0; x < before.width; ++x) {
            float expected = before(x, y);
            for (int v = std::max(0, y - 1); v <= std::min(before.height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(before.width - 1, x + 1); ++u)
                    expected = std::max(expected, far_part * before(u, v));
            CHECK(part.pixels(x, y) == expected);
        }
}

TEST_CASE("Inverse depth: contours of a picture one pixel wide or of none can be widened") {
    InverseDepthPart column{0, 0, Image<float>(1, 3, 0.0F)};
    column.pixels(0, 1) = 1;
    widen_far_contours(column, 0.5F);
    CHECK(column.pixels(0, 0) == 0.5F);
    CHECK(column.pixels(0, 1) == 1);
    InverseDepthPart nothing;
    widen_far_contours(nothing, 0.5F);
    CHECK(nothing.pixels.pixels.empty());
}

TEST_CASE("Inverse depth: each pixel becomes the largest of four, but for the last row and column") {
    const Image<float> before = noise();
    Image<float> after = before;
    take_largest_of_four(after);
    for (int y = 0; y < before.height; ++y)
        for (int x = 0; x < before.width; ++x) {
            const bool is_last = x + 1 == before.width || y + 1 == before.height;
            const float expected =
                is_last ? before(x, y)
                        : std::max({before(x, y), before(x + 1, y), before(x, y + 1), before(x + 1, y + 1)});
            CHECK(after(x, y) == expected);
        }
    Image<float> nothing;
    take_largest_of_four(nothing);
    CHECK(nothing.pixels.empty());
}
