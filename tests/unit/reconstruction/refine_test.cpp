#include "core/reconstruction/refine.h"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <thread>

#include "core/error.h"
#include "core/mesh/topology.h"
#include "core/progressive/batch_selection.h"
#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"
#include "tests/grid_scenes.h"

using namespace anyrate;

namespace {

/// Keeps what it is told, and replays it as a decoder would.
class Recorder final : public ModelSink {
public:
    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override {
        replayed.emplace(base, grid, rules);
        return base;
    }
    void base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) override {
        n_colours = colours.size();
        psi.push_back(distortion.mean);
    }
    void batch(std::span<const SplitRecord> batch, const RefinableMesh& state, std::span<const Rgb8> colours,
               const DistortionPoint& distortion) override {
        for (const SplitRecord& record : batch) replayed->apply(record);
        records.insert(records.end(), batch.begin(), batch.end());
        closed_loop = closed_loop && replayed->state_hash() == state.state_hash();
        n_colours += colours.size();
        psi.push_back(distortion.mean);
        on_batch();
    }
    void finish() override { finished = true; }

    std::optional<RefinableMesh> replayed;
    std::vector<SplitRecord> records;
    std::vector<double> psi;
    std::size_t n_colours = 0;
    bool closed_loop = true, finished = false;
    std::function<void()> on_batch = [] {};
};

const Capture& capture() {
    static const Capture sphere = painted_sphere(10, 128, wavy_paint);
    return sphere;
}

/// Sees less agreement whenever it is asked again: no batch can lower its Psi.
class GrowingDistortion final : public PhotoBackend {
public:
    void set_surface(const SurfaceView&, int, double, std::span<const std::int32_t>) override {
        ++phi_;
        on_call();
    }
    std::vector<TriangleDistortion> distortions(std::span<const TriangleQuery> batch) override {
        on_call();
        return std::vector<TriangleDistortion>(batch.size(), {phi_, 1.0});
    }
    std::vector<TriangleTerms> terms(std::span<const TriangleQuery> batch,
                                     std::span<const std::array<Vec3, 3>>) override {
        TriangleTerms term;
        term.distortion = {phi_, 1.0};
        term.middle_hessian = {1.0, 1.0, 1.0};
        return std::vector<TriangleTerms>(batch.size(), term);
    }
    double pixel_size(std::int32_t) const override { return 0.01; }
    int n_levels() const override { return 1; }

    std::function<void()> on_call = [] {};

private:
    double phi_ = 0;
};

const ReconstructOptions small{.n_vertices = 900, .n_coarse = 300, .seed = 1, .method = Method::refine};

}  // namespace

TEST_CASE("Batch: its splits share no vertex, have positive scores and come in ascending order") {
    const RefinableMesh mesh(on_grid(icosphere(3), unit_grid), unit_grid, {});
    std::vector<double> scores(static_cast<std::size_t>(mesh.n_faces()));
    for (std::size_t f = 0; f < scores.size(); ++f) scores[f] = std::sin(static_cast<double>(f));
    const auto batch = select_batch(mesh, scores, 40);
    CHECK(batch.size() == 40);
    std::vector<int> moved(static_cast<std::size_t>(mesh.n_vertices()), 0);
    for (std::size_t k = 0; k < batch.size(); ++k) {
        CHECK(scores[static_cast<std::size_t>(batch[k])] > 0);
        if (k > 0) CHECK(batch[k - 1] < batch[k]);
        const auto site = mesh.split_site(batch[k]);
        REQUIRE(site.has_value());
        for (std::int32_t v : *site) CHECK(++moved[static_cast<std::size_t>(v)] == 1);
    }
}

TEST_CASE("Batch: the highest score is always taken") {
    const RefinableMesh mesh(on_grid(icosphere(2), unit_grid), unit_grid, {});
    std::vector<double> scores(static_cast<std::size_t>(mesh.n_faces()), 1.0);
    scores[77] = 2.0;
    CHECK(select_batch(mesh, scores, 1) == std::vector<std::int32_t>{77});
    CHECK(select_batch(mesh, std::vector<double>(scores.size(), 0.0), 5).empty());
}

TEST_CASE("Batch size: batches of one growth, near the one asked for, lead to the count without a crumb") {
    for (const int n_vertices : {3000, 10'000, 20'000}) {
        const RefineOptions options{.n_vertices = n_vertices};
        double least = 1, most = 0;
        for (int n = 2500; n + 3 <= n_vertices;) {
            const int added = 3 * batch_size(n, 0.2, options).taken;
            REQUIRE(added > 0);
            least = std::min(least, static_cast<double>(added) / n);
            most = std::max(most, static_cast<double>(added) / n);
            n += added;
            CHECK(n <= n_vertices);
        }
        CHECK(least > 0.16);
        CHECK(most < 0.25);
        CHECK(most < 1.02 * least);
    }
}

TEST_CASE("Refine: where no batch lowers Psi the count is met all the same, near the silhouettes") {
    RefinableMesh state(on_grid(icosphere(2), unit_grid), unit_grid, {});
    GrowingDistortion backend;
    Silhouettes silhouettes(capture());
    const PhotoImages images = make_photo_images(capture());
    const TrueSurface fitted(icosphere(5), 20'000);
    Recorder recorder;
    recorder.start(state.grid(), {}, on_grid(icosphere(2), unit_grid));
    RefineOptions options;
    options.n_vertices = 1000;
    options.follows_images = true;
    options.followed_growth = 0.5;
    const GuessedSurface none;
    const std::vector<CurvePoint> curve =
        refine(state, backend, {images, silhouettes, none, fitted}, options, recorder, {}, {});
    CHECK(recorder.closed_loop);
    CHECK(state.n_vertices() >= options.n_vertices - 2);
    CHECK(curve.back().psi > curve.front().psi);
    for (const Vec3& v : state.to_mesh().vertices)
        CHECK(std::abs(v.norm() - 1.0) < 0.05);  // a sixth of an edge of the base
}

TEST_CASE("Refine: all vertices approach the fitted surface, unless the batches follow the images") {
    constexpr double radius = 1.03;
    Silhouettes silhouettes((Capture()));
    const PhotoImages images = make_photo_images(capture());
    const GuessedSurface none;
    const TrueSurface fitted(icosphere(5, radius), 20'000);
    const auto mean_distance = [&](const RefineOptions& options) {
        RefinableMesh state(on_grid(icosphere(3), unit_grid), unit_grid, {});
        GrowingDistortion backend;
        Recorder recorder;
        recorder.start(state.grid(), {}, on_grid(icosphere(3), unit_grid));
        refine(state, backend, {images, silhouettes, none, fitted}, options, recorder, {}, {});
        CHECK(recorder.closed_loop);
        CHECK(state.n_vertices() >= options.n_vertices - 2);
        double sum = 0;
        for (const Vec3& v : state.to_mesh().vertices) sum += std::abs(v.norm() - radius);
        return sum / state.n_vertices();
    };
    CHECK(mean_distance({.n_vertices = 2500}) < 0.003);
    // A quarter of the vertices are of the base, which these images do not move.
    CHECK(mean_distance({.n_vertices = 2500, .follows_images = true}) > 0.005);
}

namespace {

/// A refinement all of whose batches approach a sphere: each is fitted while the one before is measured and sent.
struct Approach {
    std::vector<CurvePoint> run(const std::function<void(const CurvePoint&)>& progress, std::stop_token stop = {}) {
        recorder.start(state.grid(), {}, on_grid(icosphere(3), unit_grid));
        Silhouettes silhouettes((Capture()));
        const PhotoImages images = make_photo_images(capture());
        const GuessedSurface none;
        const TrueSurface fitted(icosphere(4, 1.03), 5000);
        const RefineOptions options{.n_vertices = 1500};
        return refine(state, backend, {images, silhouettes, none, fitted}, options, recorder, progress, stop);
    }

    RefinableMesh state{on_grid(icosphere(3), unit_grid), unit_grid, {}};
    GrowingDistortion backend;
    Recorder recorder;
};

}  // namespace

TEST_CASE("Refine: backend, sink and progress are called on the calling thread") {
    Approach approach;
    int n_calls = 0, n_elsewhere = 0;
    const auto count = [&, caller = std::this_thread::get_id()] {
        ++n_calls;
        if (std::this_thread::get_id() != caller) ++n_elsewhere;
    };
    approach.backend.on_call = approach.recorder.on_batch = count;
    approach.run([&](const CurvePoint&) { count(); });
    CHECK(n_calls > 0);
    CHECK(n_elsewhere == 0);
}

TEST_CASE("Refine: the progress of a batch is told before the sink has the next one") {
    Approach approach;
    std::size_t n_told = 0;
    approach.run([&](const CurvePoint& reached) {
        CHECK(approach.recorder.psi.size() == ++n_told);
        CHECK(approach.state.n_vertices() == reached.n_vertices);
    });
    CHECK(n_told > 2);
}

TEST_CASE("Refine: a stop ends with the batch that was sent, although the next one may have been fitted") {
    Approach approach;
    std::stop_source stop;
    const auto curve = approach.run([&](const CurvePoint&) { stop.request_stop(); }, stop.get_token());
    CHECK(curve.size() == 2);
    CHECK(approach.recorder.psi.size() == 1);
    CHECK(approach.recorder.replayed->state_hash() == approach.state.state_hash());
}

TEST_CASE("Refine: a sink that throws ends it with its own exception") {
    Approach approach;
    approach.recorder.on_batch = [] { throw IoError("disk full"); };
    CHECK_THROWS_AS(approach.run({}), IoError);
}

TEST_CASE("Reconstruct: the decoder's state is the encoder's, closed and manifold, at the count asked for") {
    Recorder recorder;
    const ReconstructResult result = reconstruct(capture(), small, recorder);
    REQUIRE(recorder.finished);
    CHECK(recorder.closed_loop);
    const int n = recorder.replayed->n_vertices();
    CHECK(n <= small.n_vertices);
    CHECK(n >= small.n_vertices - 2);
    CHECK(recorder.n_colours == static_cast<std::size_t>(n));
    const Topology topology = measure_topology(recorder.replayed->to_mesh());
    CHECK(topology.is_closed_manifold());
    CHECK(topology.n_components == 1);
    CHECK(topology.euler == 2);
    CHECK(result.curve.size() == recorder.psi.size());
    CHECK(result.curve.back().n_vertices == n);
}

TEST_CASE("Reconstruct: the surface comes nearer to the sphere than its silhouettes tell") {
    Recorder recorder;
    reconstruct(capture(), small, recorder);
    double error = 0;
    int n_seen = 0;
    for (const Vec3& v : recorder.replayed->to_mesh().vertices)
        if (std::abs(v.z()) < 0.6) {
            error += std::abs(v.norm() - 1.0);
            ++n_seen;
        }
    CHECK(error / n_seen < 0.25 / 50);  // a quarter of a pixel
}

TEST_CASE("Reconstruct: Psi at the end is below that of the coarse mesh and of plain surface flow") {
    Recorder refined, flowed;
    reconstruct(capture(), small, refined);
    ReconstructOptions flow = small;
    flow.method = Method::flow;
    reconstruct(capture(), flow, flowed);
    CHECK(refined.psi.back() < refined.psi.front());
    CHECK(refined.psi.back() < flowed.psi.back());
    CHECK(flowed.replayed->n_vertices() == doctest::Approx(small.n_vertices).epsilon(0.02));
    CHECK(flowed.records.empty());
}

TEST_CASE("Reconstruct: Psi falls at every batch that follows the images, also where noise leaves little to gain") {
    Capture noisy = capture();
    std::uint32_t random = 1;  // a linear congruential generator, Numerical Recipes' constants
    for (View& view : noisy.views)
        for (Rgb8& pixel : view.image.pixels) {
            random = 1664525U * random + 1013904223U;
            const auto disturbed = [&](std::uint8_t c, int shift) {
                return static_cast<std::uint8_t>(std::clamp(c + static_cast<int>((random >> shift) % 41) - 20, 0, 255));
            };
            pixel = {disturbed(pixel.r, 8), disturbed(pixel.g, 14), disturbed(pixel.b, 20)};
        }
    Recorder recorder;
    const ReconstructOptions options{.n_vertices = 1600, .n_coarse = 800, .follows_images = true};
    const std::vector<CurvePoint> curve = reconstruct(noisy, options, recorder).curve;
    REQUIRE(curve.size() > 3);
    for (std::size_t i = 1; i < curve.size(); ++i) CHECK(curve[i].psi < curve[i - 1].psi);
}

TEST_CASE("Reconstruct: one and two threads write the same records") {
    const auto run = [](std::size_t n_threads) {
        const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, n_threads);
        Recorder recorder;
        reconstruct(capture(), small, recorder);
        return std::pair(recorder.records, recorder.replayed->state_hash());
    };
    CHECK(run(1) == run(2));
}

TEST_CASE("Reconstruct: a stop leaves a finished model that ends at a whole batch") {
    Recorder recorder;
    std::stop_source stop;
    const auto stop_in_refinement = [&](const Progress& p) {
        if (p.stage == Stage::refine && p.n_vertices > 400) stop.request_stop();
    };
    const ReconstructResult result = reconstruct(capture(), small, recorder, stop_in_refinement, stop.get_token());
    CHECK(result.stopped);
    CHECK(recorder.finished);
    CHECK(recorder.replayed->n_vertices() < small.n_vertices);
    CHECK(recorder.replayed->n_vertices() > small.n_coarse);
}

TEST_CASE("Reconstruct: progress never goes back, and optimising is not told to be over while it lasts") {
    Recorder recorder;
    std::vector<Progress> told;
    reconstruct(capture(), small, recorder, [&](const Progress& p) { told.push_back(p); });
    REQUIRE(told.size() > 5);
    for (std::size_t i = 0; i < told.size(); ++i) {
        if (told[i].stage == Stage::optimise) CHECK(told[i].fraction < 1);
        if (i == 0) continue;
        CHECK(told[i].stage >= told[i - 1].stage);
        if (told[i].stage == told[i - 1].stage) CHECK(told[i].fraction >= told[i - 1].fraction);
    }
}

TEST_CASE("Reconstruct: counts out of range are refused with what was expected") {
    Recorder recorder;
    ReconstructOptions options = small;
    options.n_coarse = 5;
    CHECK_THROWS_AS(reconstruct(capture(), options, recorder), InputError);
    options = small;
    options.n_vertices = options.n_coarse - 1;
    CHECK_THROWS_AS(reconstruct(capture(), options, recorder), InputError);
}
