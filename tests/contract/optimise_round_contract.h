#pragma once
// What PhotoBackend::optimise_round() must keep (core/reconstruction/photo_backend.h): the CPU's loop is the rule.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "core/reconstruction/optimise_round.h"
#include "core/simulation/parametric_meshes.h"
#include "tests/scenes.h"

namespace anyrate {

/// A surface that is to be moved, and which part of it.
struct RoundCase {
    std::string name;
    Mesh mesh;
    std::vector<std::int32_t> active;
    std::vector<std::int32_t> left_out;  ///< faces that the images are not asked about
    OptimiseOptions options;
    double damping = 0.1;
    int n_rounds = 1;
    bool has_silhouettes = true;
    bool comes_nearer = false;  ///< to the sphere of radius 1 that the images show
};

namespace round_contract {

inline Mesh shaken(Mesh mesh, double by, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> offset(-by, by);
    for (Vec3& v : mesh.vertices) v += Vec3(offset(random), offset(random), offset(random));
    return mesh;
}

inline std::vector<std::int32_t> every(std::int32_t nth, std::int32_t n) {
    std::vector<std::int32_t> list;
    for (std::int32_t i = 0; i < n; i += nth) list.push_back(i);
    return list;
}

/// Neighbourhoods of nine vertices or so that hardly touch each other, as a batch of splits has them.
inline std::vector<std::int32_t> scattered(const Mesh& mesh, std::int32_t nth) {
    const OneRings rings(mesh);
    std::vector<std::int32_t> active;
    for (const std::int32_t v : every(nth, mesh.n_vertices())) {
        active.push_back(v);
        const auto ring = rings.neighbours(v);
        active.insert(active.end(), ring.begin(), ring.end());
    }
    std::ranges::sort(active);
    active.erase(std::unique(active.begin(), active.end()), active.end());
    return active;
}

inline std::vector<RoundCase> cases() {
    std::vector<RoundCase> cases;
    for (const int level : {0, 1}) {
        const Mesh mesh = shaken(icosphere(3, 0.98), 0.01, 1);
        RoundCase whole{"all of a sphere", mesh, every(1, mesh.n_vertices()), {}, {.level = level}};
        whole.n_rounds = 2;
        whole.options.silhouette_reach_px = 8;
        whole.comes_nearer = true;
        cases.push_back(whole);
    }
    const Mesh mesh = shaken(icosphere(4, 1.01), 0.006, 2);
    RoundCase batch{"neighbourhoods", mesh, scattered(mesh, 41), {}, {.bending = 0.01}};
    cases.push_back(batch);
    batch.name = "neighbourhoods, not all faces asked about";
    batch.left_out = every(5, mesh.n_faces());
    cases.push_back(batch);
    batch.name = "neighbourhoods, too little damping";
    batch.damping = 0;
    batch.options.max_step_px = 40;
    cases.push_back(batch);
    // Too far off to see its way, it is refused steps that are not damped at all, in the end all trials of one.
    const Mesh small = icosphere(3, 0.9);
    RoundCase undamped{
        "not damped at all", small, every(1, small.n_vertices()), {}, {.max_step_px = 10, .bending = 0}, 0, 8};
    cases.push_back(undamped);
    const Mesh ring = shaken(torus(0.65, 0.3, 40, 24), 0.01, 3);
    cases.push_back({"a ring that is nowhere near", ring, every(1, ring.n_vertices()), {}, {.steps_per_round = 4}});
    cases.push_back({"one step, taken on trust", mesh, every(3, mesh.n_vertices()), {}, {.steps_per_round = 1}});
    RoundCase bare{"without silhouettes", mesh, scattered(mesh, 41), {}, {}};
    bare.has_silhouettes = false;
    cases.push_back(bare);
    cases.push_back({"one vertex", mesh, {17}, {}, {}});
    RoundCase converged{
        "a sphere that stands where it should", icosphere(3), every(1, icosphere(3).n_vertices()), {}, {}};
    converged.n_rounds = 6;
    cases.push_back(converged);
    return cases;
}

inline double mean_error(std::span<const Vec3> vertices) {
    double sum = 0;
    for (const Vec3& v : vertices) sum += std::abs(v.norm() - 1);
    return sum / static_cast<double>(vertices.size());
}

struct Rounds {
    std::vector<std::vector<Vec3>> vertices;  ///< after each round
    std::vector<RoundOutcome> outcomes;
};

inline Rounds take(const RoundCase& scene, PhotoBackend& backend, const Capture& capture) {
    Silhouettes silhouettes(scene.has_silhouettes ? capture : Capture());
    Mesh mesh = scene.mesh;
    const OneRings rings(mesh);
    const std::vector<std::int32_t> around = faces_around(rings, scene.active);
    std::vector<std::int32_t> faces;
    std::ranges::set_difference(around, scene.left_out, std::back_inserter(faces));
    OptimiseRound round{mesh.triangles, rings, scene.active, around, faces, scene.options, silhouettes};
    Rounds taken;
    double damping = scene.damping;
    for (int r = 0; r < scene.n_rounds; ++r) {
        taken.outcomes.push_back(backend.optimise_round(round, mesh.vertices, damping));
        taken.vertices.push_back(mesh.vertices);
        damping = scene.damping > 0 ? taken.outcomes.back().damping : 0;
        round.is_first = false;
    }
    return taken;
}

}  // namespace round_contract

/// A pixel at the edge of the rendered surface that one backend takes for covered and the other does not decides whether
/// a vertex is drawn to the outline, and moves its neighbourhood: one vertex in fifty may miss the tolerance for that.
/// @param tolerance_px  of a vertex, pixels of the level
inline void check_optimise_round(const BackendFactory& make, double tolerance_px) {
    const Capture capture = sphere_capture(8, 160);
    const PhotoImages images = make_photo_images(capture, 3);
    const auto cpu = make_cpu_backend(images, Sampling::adaptive);
    const auto backend = make(images, Sampling::adaptive);
    int n_taken = 0, n_rolled_back = 0;
    for (const RoundCase& scene : round_contract::cases()) {
        CAPTURE(scene.name);
        CAPTURE(scene.options.level);
        const auto expected = round_contract::take(scene, *cpu, capture);
        const auto got = round_contract::take(scene, *backend, capture);
        std::vector<char> is_active(scene.mesh.vertices.size(), 0);
        for (const std::int32_t v : scene.active) is_active[static_cast<std::size_t>(v)] = 1;
        const double pixel = backend->pixel_size(OneRings(scene.mesh).faces(scene.active.front()).front());
        for (std::size_t r = 0; r < expected.outcomes.size(); ++r) {
            CAPTURE(r);
            CHECK(got.outcomes[r].falls == expected.outcomes[r].falls);
            CHECK(got.outcomes[r].is_faint == expected.outcomes[r].is_faint);
            CHECK(got.outcomes[r].damping == doctest::Approx(expected.outcomes[r].damping));
            const std::vector<Vec3>& before = r == 0 ? scene.mesh.vertices : got.vertices[r - 1];
            double largest = 0, farthest = 0;
            std::size_t n_off = 0;
            for (std::size_t v = 0; v < before.size(); ++v) {
                if (is_active[v] == 0) CHECK(got.vertices[r][v] == scene.mesh.vertices[v]);
                const double off = (got.vertices[r][v] - expected.vertices[r][v]).norm() / pixel;
                n_off += off > tolerance_px ? 1 : 0;
                largest = std::max(largest, off);
                farthest = std::max(farthest, (got.vertices[r][v] - before[v]).norm() / pixel);
            }
            CHECK(n_off <= (scene.has_silhouettes ? scene.active.size() / 50 : 0));
            CHECK(largest <= 0.05);
            // A pixel is wider on some faces than on others.
            CHECK(farthest <= 1.5 * scene.options.steps_per_round * scene.options.max_step_px);
            if (scene.comes_nearer)
                CHECK(round_contract::mean_error(got.vertices[r]) <
                      0.5 * round_contract::mean_error(scene.mesh.vertices));
            (farthest > 0 ? n_taken : n_rolled_back) += 1;
            // A round that does not fall and is rolled back leaves the surface as it was, to the last bit.
            if (expected.vertices[r] == (r == 0 ? scene.mesh.vertices : expected.vertices[r - 1]))
                CHECK(got.vertices[r] == before);
        }
    }
    CHECK(n_taken > 5);
    CHECK(n_rolled_back > 0);
}

/// Whether the images tell less than noise would is said of the same images on every backend.
inline void check_faintness(const BackendFactory& make) {
    Capture capture = sphere_capture(8, 160);
    const Mesh mesh = icosphere(3, 0.98);
    const RoundCase scene{"all of a sphere", mesh, round_contract::every(1, mesh.n_vertices()), {}, {}};
    const auto is_faint = [&] {
        const PhotoImages images = make_photo_images(capture, 3);
        return round_contract::take(scene, *make(images, Sampling::adaptive), capture).outcomes.front().is_faint;
    };
    CHECK_FALSE(is_faint());
    for (View& view : capture.views)
        for (auto& pixel : view.image.pixels)
            for (std::uint8_t* channel : {&pixel.r, &pixel.g, &pixel.b})
                *channel = static_cast<std::uint8_t>(120 + *channel / 32);
    CHECK(is_faint());
}

}  // namespace anyrate
