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

/// Of the nodes at these heights on the axis that the views look along.
RowVotes votes_at(std::span<const DepthMap> maps, std::initializer_list<double> heights,
                  const VoteOptions& options = {}) {
    RowVotes all;
    for (const double z : heights) {
        RowVotes one{{7.0f}, {7.0f}};  // whatever was there before
        depth_votes(maps, {Vec3(0, 0, z), 1.0}, one, options);
        all.sum.push_back(one.sum[0]);
        all.weight.push_back(one.weight[0]);
    }
    return all;
}

}  // namespace

TEST_CASE("Seen through: a point goes if enough views see the surface behind it") {
    const std::vector<OrientedPoint> lid = {point_at(-0.5)};
    const std::vector<DepthMap> maps(3, wall_at_zero(4));
    CHECK(without_seen_through(lid, maps, {.n_views = 3}).empty());
    CHECK(without_seen_through(lid, maps, {.n_views = 4}).size() == 1);
}

TEST_CASE("Seen through: a lid goes from a pixel of disparity on") {
    const std::vector<DepthMap> maps(3, wall_at_zero(4));
    // A pixel of disparity is about 0.04 world units of depth here.
    CHECK(without_seen_through(std::vector{point_at(-0.08)}, maps).empty());
    CHECK(without_seen_through(std::vector{point_at(-0.02)}, maps).size() == 1);
}

TEST_CASE("Seen through: a point on the surface or behind it stays") {
    const std::vector<OrientedPoint> points = {point_at(0), point_at(0.5)};
    const std::vector<DepthMap> maps(3, wall_at_zero(4));
    CHECK(without_seen_through(points, maps).size() == 2);
}

TEST_CASE("Depth votes: one outside, minus one inside, none where the surface hides the node") {
    const std::vector<DepthMap> maps(2, wall_at_zero(4));
    // A pixel of disparity is about 0.04 world units of depth here.
    const RowVotes votes = votes_at(maps, {-0.4, 0.0, 0.05, 0.4}, {.truncation_px = 2});
    CHECK(votes.sum[0] == doctest::Approx(2));
    CHECK(votes.sum[1] == doctest::Approx(0).epsilon(1e-6));
    CHECK(votes.sum[2] < -1.0f);
    CHECK(votes.weight == std::vector<float>{2, 2, 2, 0});
}

TEST_CASE("Depth votes: a vote weighs as much as the square of the images' agreement") {
    std::vector<DepthMap> maps(2, wall_at_zero(4));
    maps[1].agreement = Image<float>(33, 33, 0.5f);
    const RowVotes votes = votes_at(maps, {-0.4});
    CHECK(votes.weight[0] == doctest::Approx(1.25));
    CHECK(votes.sum[0] == doctest::Approx(1.25));
}

TEST_CASE("Depth votes: the nodes of a row are a spacing apart along the first axis") {
    DepthMap half = wall_at_zero(4);  // known where x is negative
    for (int y = 0; y < half.inverse_depth.height; ++y)
        for (int x = half.inverse_depth.width / 2; x < half.inverse_depth.width; ++x) half.inverse_depth(x, y) = 0;
    RowVotes row{std::vector<float>(2), std::vector<float>(2)};
    depth_votes(std::vector{half}, {Vec3(-0.1, 0, -0.4), 0.2}, row);
    CHECK(row.weight == std::vector<float>{1, 0});
}

TEST_CASE("Depth votes: the votes of several views add up") {
    const std::vector<DepthMap> maps = {wall_at_zero(4), wall_at_zero(4), DepthMap{}};
    std::vector<DepthMap> moved = maps;
    moved[1].inverse_depth = Image<float>(33, 33, static_cast<float>(1 / 3.0));  // a wall nearer to this view
    const RowVotes votes = votes_at(moved, {-1});
    CHECK(votes.weight[0] == 2);
    CHECK(votes.sum[0] == doctest::Approx(1).epsilon(0.05));  // on its wall, in front of the other
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
