// What depth maps say of a place: seen through, outside, inside, hidden, shown.
#include <doctest/doctest.h>

#include <vector>

#include "core/reconstruction/depth_votes.h"
#include "core/reconstruction/guessed_surface.h"
#include "core/reconstruction/initial_mesh.h"
#include "core/reconstruction/seen_through.h"
#include "core/simulation/parametric_meshes.h"
#include "core/simulation/simulate.h"
#include "depth_scene.h"

using namespace anyrate;

namespace {

const Vec3 towards_camera(0, 0, -1);

OrientedPoint point_at(double z) { return {Vec3(0, 0, z), towards_camera, 1.0}; }

float vote_at(const VoteField& field, int k) {
    return field.mean[static_cast<std::size_t>((k * field.ny + field.ny / 2) * field.nx + field.nx / 2)];
}
float weight_at(const VoteField& field, int k) {
    return field.weight[static_cast<std::size_t>((k * field.ny + field.ny / 2) * field.nx + field.nx / 2)];
}

}  // namespace

TEST_CASE("Seen through: a point goes if enough views see the surface behind it") {
    const std::vector<OrientedPoint> lid = {point_at(-0.5)};
    const std::vector<DepthMap> maps(3, wall_at_zero(4));
    CHECK(without_seen_through(lid, maps, {.n_views = 3}).empty());
    CHECK(without_seen_through(lid, maps, {.n_views = 4}).size() == 1);
}

TEST_CASE("Seen through: a point on the surface or behind it stays") {
    const std::vector<OrientedPoint> points = {point_at(0), point_at(0.5)};
    const std::vector<DepthMap> maps(3, wall_at_zero(4));
    CHECK(without_seen_through(points, maps).size() == 2);
}

TEST_CASE("Depth votes: one outside, minus one inside, none where the surface hides the node") {
    const std::vector<DepthMap> maps(2, wall_at_zero(4));
    // A pixel of disparity is about 0.04 world units of depth here; nodes from z = -0.4 to 0.4.
    const VoteField field =
        depth_votes(Vec3(-0.1, -0.1, -0.4), Vec3(0.1, 0.1, 0.4), maps, {.spacing = 0.05, .truncation_px = 2});
    CHECK(vote_at(field, 0) == doctest::Approx(1));
    CHECK(vote_at(field, 8) == doctest::Approx(0).epsilon(1e-6));
    CHECK(vote_at(field, 9) < -0.5f);
    CHECK(weight_at(field, 9) == 2);
    CHECK(weight_at(field, 16) == 0);
}

TEST_CASE("Depth votes: the votes of several views are averaged") {
    const std::vector<DepthMap> maps = {wall_at_zero(4), wall_at_zero(4), DepthMap{}};
    std::vector<DepthMap> moved = maps;
    moved[1].inverse_depth = Image<float>(33, 33, static_cast<float>(1 / 3.0));  // a wall nearer to this view
    const VoteField field = depth_votes(Vec3(-0.1, -0.1, -1.02), Vec3(0.1, 0.1, 0), moved, {.spacing = 0.02});
    CHECK(weight_at(field, 1) == 2);
    CHECK(vote_at(field, 1) == doctest::Approx(0.5).epsilon(0.05));  // on its wall, in front of the other
}

TEST_CASE("Guessed surface: neither a silhouette nor a view shows the back of a wall") {
    // Two squares, one at the depth the maps know, the other behind it.
    const Mesh walls{
        .vertices = {Vec3(0, 0, 0), Vec3(0, 0.1, 0), Vec3(0.1, 0, 0), Vec3(0, 0, 1), Vec3(0, 0.1, 1), Vec3(0.1, 0, 1)},
        .triangles = {{0, 1, 2}, {3, 4, 5}},
        .colours = {}};
    const std::vector<DepthMap> maps(2, wall_at_zero(4));
    const std::vector<OrientedPoint> elsewhere = {point_at(-2)};
    const std::vector<char> seen(6, 0), unseen(6, 1);
    const auto guessed = guessed_points(walls, seen, {elsewhere, elsewhere}, maps, {.reach = 0.1});
    REQUIRE(guessed.size() == 3);
    for (const OrientedPoint& point : guessed) CHECK(point.position.z() == 1);
    const std::vector<OrientedPoint> silhouette = {{Vec3(0, 0.05, 1), towards_camera, 1.0}};
    CHECK(guessed_points(walls, seen, {silhouette, elsewhere}, maps, {.reach = 0.2}).empty());
    CHECK(guessed_points(walls, unseen, {silhouette, silhouette}, maps, {.reach = 0.2}).empty());
    CHECK(guessed_points(walls, unseen, {silhouette, elsewhere}, maps, {.reach = 0.2}).size() == 3);
}

TEST_CASE("Guessed surface: vertices near a guessed point that face the same way are flagged") {
    const Mesh wall{.vertices = {Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(1, 0, 0)}, .triangles = {{0, 1, 2}}, .colours = {}};
    CHECK(GuessedSurface({point_at(0)}, 0.5).vertices(wall) == std::vector<char>{1, 0, 0});
    CHECK(GuessedSurface({{Vec3::Zero(), Vec3(0, 0, 1), 0.0}}, 0.5).vertices(wall) == std::vector<char>{0, 0, 0});
    CHECK(GuessedSurface().vertices(wall) == std::vector<char>{0, 0, 0});
}
