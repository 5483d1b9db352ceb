#include "core/simulation/ring_cameras.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "tests/scenes.h"

namespace anyrate {

TEST_CASE("Ring cameras: proper rotations, all of the object in front and within the part of the image asked for") {
    const Mesh mesh = torus(40, 15, 40, 20);
    const auto cameras =
        ring_cameras(mesh.vertices, {.n_views = 9, .width = 320, .height = 240, .fill = 0.9, .seed = 3});
    REQUIRE(cameras.size() == 9);
    double fullest = 0;
    for (const Camera& camera : cameras) {
        CHECK((camera.R * camera.R.transpose() - Mat3::Identity()).norm() < 1e-12);
        CHECK(camera.R.determinant() == doctest::Approx(1));
        const Vec2 principal_point(camera.K(0, 2), camera.K(1, 2));
        for (const Vec3& vertex : mesh.vertices) {
            REQUIRE(camera.cam_from_world(vertex).z() > 0);
            const Vec2 part = 2 * (camera.project(vertex) - principal_point).cwiseAbs().cwiseQuotient(Vec2(320, 240));
            fullest = std::max(fullest, part.maxCoeff());
        }
    }
    CHECK(fullest == doctest::Approx(0.9));
}

TEST_CASE("Ring cameras: world up is up in the image, and every third camera looks down more steeply") {
    const Mesh mesh = icosphere(2);
    const auto cameras = ring_cameras(mesh.vertices, {.n_views = 12, .width = 320, .height = 240});
    for (std::size_t k = 0; k < cameras.size(); ++k) {
        const Vec2 drawn = cameras[k].project(Vec3(0, 0, 0.1)) - cameras[k].project(Vec3::Zero());
        CHECK(drawn.y() < -5 * std::abs(drawn.x()));
        const Vec3 centre = cameras[k].centre();
        const double sine = centre.z() / centre.norm();
        CHECK((k % 3 == 2 ? sine > 0.6 : sine < 0.45));
    }
}

}  // namespace anyrate
