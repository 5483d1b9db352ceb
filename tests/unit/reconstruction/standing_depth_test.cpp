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

/// Depth that is kept is that of the whole scene, before and after each of some changes, one upon the other.
class KeptDepth {
public:
    explicit KeptDepth(Scene& scene) : scene_(scene) { REQUIRE(count_different(standing_, scene_) == 0); }

    void after(const char* change, const std::function<void()>& make) {
        CAPTURE(change);
        make();
        CHECK(count_different(standing_, scene_) == 0);
    }
    std::span<const std::int32_t> moving_vertices() const { return standing_.moving_vertices(); }

private:
    Scene& scene_;
    StandingDepth standing_;
};

}  // namespace

TEST_CASE("Standing depth: with what moved drawn over it, it is that of the whole surface, to the bit") {
    Scene scene;
    KeptDepth kept(scene);
    kept.after("forwards", [&] { scene.move_vertices(0.1); });
    kept.after("and back, which shows what stands behind", [&] { scene.move_vertices(-0.3); });
    kept.after("a larger box", [&] { scene.box = {4, 20, 91, 70}; });
    kept.after("a box within", [&] { scene.box = {40, 33, 44, 39}; });
    kept.after("one beside", [&] { scene.box = {0, 0, 50, 40}; });
}

TEST_CASE("Standing depth: what stood elsewhere, or before other cameras, is forgotten") {
    Scene scene;
    scene.box = {0, 0, 96, 96};
    KeptDepth kept(scene);
    kept.after("one vertex that stood still", [&] { scene.mesh.vertices.back() *= 1.2; });
    kept.after("a camera",
               [&] { scene.images.views[1].levels[0].P.row(0) += scene.images.views[1].levels[0].P.row(2); });
    kept.after("less that moves", [&] { scene.moving.resize(200); });
    kept.after("faces that are turned over", [&] {
        for (std::size_t f = 400; f < 1600; f += 2) std::swap(scene.mesh.triangles[f][0], scene.mesh.triangles[f][1]);
    });
    kept.after("a finer mesh", [&] { scene.mesh = torus(0.6, 0.25, 60, 30); });
    kept.after("a coarser level", [&] {
        scene.level = 1;
        scene.box = {0, 0, 48, 48};
    });
    kept.after("fewer views", [&] { scene.images.views.pop_back(); });
    kept.after("another part that moves", [&] { scene.moving = {7}; });
    const Triangle& face = scene.mesh.triangles[7];
    CHECK(std::ranges::is_permutation(kept.moving_vertices(), face));
}
