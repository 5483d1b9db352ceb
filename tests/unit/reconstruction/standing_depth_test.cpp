#include "core/reconstruction/standing_depth.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>

#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// A torus before cameras around it, some of its faces on the move.
struct Scene {
    PhotoImages images = make_photo_images(painted_sphere(4, 96, wavy_paint), 2);
    Mesh mesh = torus(0.6, 0.25, 40, 20);
    std::vector<std::int32_t> moving;
    int level = 0;
    PixelBox box{30, 30, 60, 60};

    Scene() {
        for (std::int32_t f = 100; f < 400; ++f) moving.push_back(f);
    }

    /// Of vertices whose faces all move; `part` of the way from the origin.
    void move_vertices(double part) {
        std::vector<char> stands(mesh.vertices.size());
        auto next = moving.begin();
        for (std::int32_t f = 0; f < mesh.n_faces(); ++f) {
            if (next != moving.end() && *next == f) {
                ++next;
                continue;
            }
            for (const std::int32_t v : mesh.triangles[at(f)]) stands[at(v)] = 1;
        }
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
            if (stands[v] == 0) mesh.vertices[v] *= 1 + part;
    }
};

/// Pixels in all views that differ from those of a picture of the whole surface.
int count_different(StandingDepth& standing, const Scene& scene) {
    standing.keep(scene.images, scene.level, scene.mesh, scene.moving);
    int n_different = 0;
    for (std::size_t i = 0; i < scene.images.views.size(); ++i) {
        const PhotoLevel& image = scene.images.views[i].levels[at(scene.level)];
        const Image<float> whole = render_inverse_depth(image, scene.mesh);
        const InverseDepthPart part =
            standing.draw(i, image, scene.box, project(image, scene.mesh, standing.moving_vertices()));
        for (int y = scene.box.y0; y < scene.box.y1; ++y)
            for (int x = scene.box.x0; x < scene.box.x1; ++x)
                n_different += part.pixels(x - part.x, y - part.y) != whole(x, y) ? 1 : 0;
    }
    return n_different;
}

}  // namespace

TEST_CASE("Standing depth: with what moved drawn over it, it is that of the whole surface, to the bit") {
    Scene scene;
    StandingDepth standing;
    REQUIRE(count_different(standing, scene) == 0);
    const auto after = [&](const char* change, const std::function<void()>& make) {
        CAPTURE(change);
        make();
        CHECK(count_different(standing, scene) == 0);
    };
    after("forwards", [&] { scene.move_vertices(0.1); });
    after("and back, which shows what stands behind", [&] { scene.move_vertices(-0.3); });
    after("a larger box", [&] { scene.box = {4, 20, 91, 70}; });
    after("a box within", [&] { scene.box = {40, 33, 44, 39}; });
    after("one beside", [&] { scene.box = {0, 0, 50, 40}; });
}

TEST_CASE("Standing depth: what stood elsewhere, or before other cameras, is forgotten") {
    Scene scene;
    scene.box = {0, 0, 96, 96};
    StandingDepth standing;
    REQUIRE(count_different(standing, scene) == 0);
    const auto after = [&](const char* change, const std::function<void()>& make) {
        CAPTURE(change);
        make();
        CHECK(count_different(standing, scene) == 0);
    };
    after("one vertex that stood still", [&] { scene.mesh.vertices.back() *= 1.2; });
    after("a camera", [&] { scene.images.views[1].levels[0].P.row(0) += scene.images.views[1].levels[0].P.row(2); });
    after("less that moves", [&] { scene.moving.resize(200); });
    after("faces that are turned over", [&] {
        for (std::size_t f = 400; f < 1600; f += 2) std::swap(scene.mesh.triangles[f][0], scene.mesh.triangles[f][1]);
    });
    after("a finer mesh", [&] { scene.mesh = torus(0.6, 0.25, 60, 30); });
    after("a coarser level", [&] {
        scene.level = 1;
        scene.box = {0, 0, 48, 48};
    });
    after("fewer views", [&] { scene.images.views.pop_back(); });
    after("another part that moves", [&] { scene.moving = {7}; });
    const Triangle& face = scene.mesh.triangles[7];
    CHECK(std::ranges::is_permutation(standing.moving_vertices(), face));
}
