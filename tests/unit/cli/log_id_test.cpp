#include "server/cli/log_id.h"

#include <doctest/doctest.h>

#include <set>

#include "tests/scenes.h"

using namespace anyrate;

TEST_CASE("Log id: the same capture and options have the same id") {
    CHECK(log_id_of(sphere_capture(3, 32), {}) == log_id_of(sphere_capture(3, 32), {}));
}

TEST_CASE("Log id: whatever changes the model changes the id") {
    const Capture capture = sphere_capture(3, 32);
    std::set<std::uint64_t> ids = {log_id_of(capture, {})};
    const auto is_new = [&](const Capture& c, const ReconstructOptions& o) {
        return ids.insert(log_id_of(c, o)).second;
    };

    CHECK(is_new(capture, {.n_vertices = 9'999}));
    CHECK(is_new(capture, {.n_coarse = 2'499}));
    CHECK(is_new(capture, {.seed = 2}));
    CHECK(is_new(capture, {.method = Method::flow}));
    CHECK(is_new(capture, {.sampling = Sampling::uniform}));
    CHECK(is_new(capture, {.samples_per_px = 2}));
    Capture other = capture;
    other.views[1].image(3, 4).g ^= 1;
    CHECK(is_new(other, {}));
    other = capture;
    other.views[2].mask(3, 4) ^= 255;
    CHECK(is_new(other, {}));
    other = capture;
    other.views[0].camera.t.x() += 1e-9;
    CHECK(is_new(other, {}));
}
