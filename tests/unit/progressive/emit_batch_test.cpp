#include "core/progressive/emit_batch.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>

#include "core/simulation/parametric_meshes.h"
#include "tests/grid_scenes.h"

using namespace anyrate;

namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// A sphere squeezed to a disc along a slanted axis: its needles make many splits flip edges around them.
RefinableMesh disc() {
    Mesh mesh = icosphere(3);
    const Vec3 axis = Vec3(1, 2, 0.5).normalized();
    for (Vec3& v : mesh.vertices) v -= 0.9 * v.dot(axis) * axis;
    return RefinableMesh(on_grid(mesh, unit_grid), unit_grid, {.flip_rule = FlipRule::crease_preserving});
}

/// The same mesh with steps of another length.
RefinableMesh with_steps(const RefinableMesh& mesh, int step_ratio) {
    const BaseMesh base{{mesh.positions().begin(), mesh.positions().end()},
                        {mesh.triangles().begin(), mesh.triangles().end()}};
    return RefinableMesh(base, mesh.grid(), {.step_ratio = step_ratio});
}

std::int32_t zero(const ScalarSite&) { return 0; }

/// Two faces of disjoint surroundings such that splitting the first puts one of its vertices beside the second.
std::array<std::int32_t, 2> entangled_pair(const RefinableMesh& mesh) {
    for (std::int32_t f = 0; f < mesh.n_faces(); ++f) {
        const auto before = mesh.split_site(f);
        if (!before) continue;
        RefinableMesh split = mesh;
        split.split(f, zero);
        for (std::int32_t g = f + 1; g < mesh.n_faces(); ++g) {
            const auto site = mesh.split_site(g), site_after = split.split_site(g);
            if (!site || !site_after || std::ranges::find_first_of(*before, *site) != before->end()) continue;
            if (std::ranges::any_of(*site_after, [&](std::int32_t v) { return v >= mesh.n_vertices(); })) return {f, g};
        }
    }
    FAIL("no split of the disc flips an edge beyond its own surroundings");
    return {};
}

std::array<Vec3, 3> last_three(const std::vector<Vec3>& vertices) {
    return {vertices[vertices.size() - 3], vertices[vertices.size() - 2], vertices[vertices.size() - 1]};
}

BatchTargets stay(const RefinableMesh& state, std::size_t n_faces) {
    BatchTargets targets;
    targets.old_vertices = state.to_mesh().vertices;
    targets.new_vertices.resize(n_faces);
    return targets;
}

}  // namespace

TEST_CASE("Emit: a vertex of the batch keeps its own target when a later split of the batch moves it") {
    const RefinableMesh start = disc();
    const std::array<std::int32_t, 2> batch = entangled_pair(start);
    BatchTargets targets = stay(start, 2);
    RefinableMesh first = start;
    first.split(batch[0], zero);
    const std::vector<Vec3> fallen = first.to_mesh().vertices;
    targets.new_vertices[0] = last_three(fallen);

    RefinableMesh state = start;
    const auto records = emit_batch(state, batch, targets, {}, {.dead_zone = 0.0});
    REQUIRE(records.size() == 2);
    const std::vector<Vec3> ended = state.to_mesh().vertices;
    const Triangle t = start.triangles()[at(batch[0])];
    const double edge = (targets.old_vertices[at(t[0])] - targets.old_vertices[at(t[1])]).norm();
    for (std::size_t v = at(start.n_vertices()); v < fallen.size(); ++v)
        CHECK((ended[v] - fallen[v]).norm() < 0.25 * edge);
}

TEST_CASE("Emit: what is left out is not split, and the vertices of the others still go to their own targets") {
    const RefinableMesh start = disc();
    const std::vector<std::int32_t> batch{10, 200, 900};
    BatchTargets targets = stay(start, 3);
    RefinableMesh alone = start;
    alone.split(200, [](const ScalarSite& site) { return site.slot < 3 ? 12 : 0; });
    targets.new_vertices[1] = last_three(alone.to_mesh().vertices);

    RefinableMesh state = start;
    const std::vector<std::int32_t> left_out{10, 900};
    const auto records = emit_batch(state, batch, targets, left_out, {.dead_zone = 1e9});
    REQUIRE(records.size() == 1);
    CHECK(records[0].face == 200);
    CHECK(records[0].residual == std::array<std::int32_t, 3>{12, 12, 12});
    CHECK(records[0].update == std::array<std::int32_t, 6>{});
}

TEST_CASE("Emit: no scalar beyond half an edge, none for a vertex without a target, none inside the dead zone") {
    const RefinableMesh start = disc();
    const std::vector<std::int32_t> batch{200};
    BatchTargets targets = stay(start, 1);
    RefinableMesh state = start;
    SplitRecord record = emit_batch(state, batch, targets, {}, {.dead_zone = 1e9}).at(0);
    CHECK(record.residual == std::array<std::int32_t, 3>{});
    CHECK(record.update == std::array<std::int32_t, 6>{});

    targets.new_vertices[0] = {Vec3(1e3, 2e3, 3e3), Vec3(1e3, 2e3, 3e3), Vec3(1e3, 2e3, 3e3)};
    for (const int step_ratio : {20, 80, 320}) {
        CAPTURE(step_ratio);
        state = with_steps(start, step_ratio);
        record = emit_batch(state, batch, targets, {}, {.dead_zone = 1e9}).at(0);
        for (std::int32_t scalar : record.residual) CHECK(std::abs(scalar) == step_ratio / 2);
    }
}

TEST_CASE("Emit: the dead zone is a part of an edge, whatever the steps") {
    const RefinableMesh start = disc();
    const std::vector<std::int32_t> batch{200};
    const Triangle t = start.triangles()[200];
    BatchTargets targets = stay(start, 1);
    const Mesh mesh = start.to_mesh();
    const double edge = (mesh.vertices[at(t[0])] - mesh.vertices[at(t[1])]).norm();
    for (Vec3& v : targets.old_vertices) v += 0.1 * edge * v.normalized();
    for (const int step_ratio : {80, 320}) {
        CAPTURE(step_ratio);
        const auto moved = [&](double dead_zone) {
            RefinableMesh state = with_steps(start, step_ratio);
            const SplitRecord record = emit_batch(state, batch, targets, {}, {.dead_zone = dead_zone}).at(0);
            return std::ranges::count_if(record.update, [](std::int32_t scalar) { return scalar != 0; });
        };
        CHECK(moved(0.5) == 0);
        CHECK(moved(0.001) >= 4);
    }
}
