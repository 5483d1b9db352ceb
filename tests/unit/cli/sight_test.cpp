#include "server/cli/sight.h"

#include <doctest/doctest.h>

#include "tests/scenes.h"

using namespace anyrate;

namespace {

/// How a camera sees a point of the unit sphere, by the cosine between the surface normal there and the direction to
/// the camera; a coarse depth image may err at flat angles.
enum class Truth { seen, hidden, open };
Truth truth(const Vec3& p, const Camera& camera) {
    const double cosine = p.dot((camera.centre() - p).normalized());
    if (cosine > 0.5) return Truth::seen;
    return cosine < -0.1 ? Truth::hidden : Truth::open;
}

}  // namespace

TEST_CASE("Sight: a point of a sphere is seen by the cameras that it faces") {
    const Capture capture = sphere_capture(8, 160);
    const Mesh sphere = icosphere(4);
    const Sight sight(capture, sphere);
    for (const Vec3& p : icosphere(2).vertices) {
        int n_seen = 0, n_open = 0;
        for (const View& view : capture.views) {
            n_seen += truth(p, view.camera) == Truth::seen;
            n_open += truth(p, view.camera) == Truth::open;
        }
        CHECK(sight.n_views_of(p) >= n_seen);
        CHECK(sight.n_views_of(p) <= n_seen + n_open);
    }
}

TEST_CASE("Sight: no camera sees the middle of a solid") {
    const Capture capture = sphere_capture(8, 160);
    CHECK(Sight(capture, icosphere(4)).n_views_of(Vec3::Zero()) == 0);
}

TEST_CASE("Sight: a point behind a camera or out of its image is not seen by it") {
    Capture capture = sphere_capture(3, 160);
    capture.views.resize(1);
    const Sight sight(capture, icosphere(4));
    const Vec3 centre = capture.views[0].camera.centre();
    CHECK(sight.n_views_of(0.5 * centre) == 1);
    CHECK(sight.n_views_of(1.5 * centre) == 0);
    CHECK(sight.n_views_of(0.5 * centre + 10 * centre.cross(Vec3(0.1, 0.2, 1)).normalized()) == 0);
}
