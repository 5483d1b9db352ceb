#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/error.h"
#include "core/reconstruction/reconstruct.h"
#include "core/reconstruction/refine.h"
#include "eq_test_scenes.h"
#include "move_masks.h"

using namespace anyrate;

namespace {

/// What a sink was called with, from the base on, so that two runs can be compared.
class Recorder final : public ModelSink {
public:
    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override {
        state.emplace(base, grid, rules);
        hashes.push_back(state->state_hash());
        return base;
    }
    void base_attributes(std::span<const Rgb8> base_colours, const DistortionPoint& distortion) override {
        keep(base_colours, distortion);
    }
    void batch(std::span<const SplitRecord>, const RefinableMesh& now, std::span<const Rgb8> new_colours,
               const DistortionPoint& distortion) override {
        state = now;
        hashes.push_back(now.state_hash());
        keep(new_colours, distortion);
    }
    void finish() override { finished = true; }

    std::optional<RefinableMesh> state;
    std::vector<std::uint32_t> hashes;
    std::vector<Rgb8> colours;
    std::vector<double> psi;
    bool finished = false;

private:
    void keep(std::span<const Rgb8> more, const DistortionPoint& distortion) {
        colours.insert(colours.end(), more.begin(), more.end());
        psi.push_back(distortion.mean);
        psi.push_back(distortion.max);
    }
};

/// Remembers where a recorder stood at each batch.
class Journal final : public RefinementJournal {
public:
    explicit Journal(const Recorder& recorder) : recorder_(recorder) {}
    void begin(const RefinementStart& s) override { start = s; }
    void batch(std::span<const char> is_rejected) override {
        RefinementPoint point{*recorder_.state, {is_rejected.begin(), is_rejected.end()}};
        point.state.move_grid(Vec3(5, 6, 7), 3);  // the log's grid stands in the world, not in the capture's frame
        points.push_back(std::move(point));
    }

    RefinementStart start;
    std::vector<RefinementPoint> points;

private:
    const Recorder& recorder_;
};

/// A painted sphere of whose views one is darker and one is a pixel off, and whose masks are two pixels too small, so
/// that exposure, views and masks are corrected.
const Capture& uneven_capture() {
    static const Capture capture = [] {
        Capture sphere = painted_sphere(10, 128, wavy_paint);
        const auto darker = [](std::uint8_t c) { return static_cast<std::uint8_t>(0.8 * c); };
        for (Rgb8& c : sphere.views[2].image.pixels) c = {darker(c.r), darker(c.g), darker(c.b)};
        sphere.views[5].camera.K(0, 2) += 1.0;
        move_masks(sphere, -2);
        return sphere;
    }();
    return capture;
}

/// The same with so much light that does not belong to it that its log has coarser steps.
const Capture& noisy_capture() {
    static const Capture capture = [] {
        Capture sphere = uneven_capture();
        for (std::size_t i = 0; i < sphere.views.size(); ++i)
            for (std::size_t p = 0; p < sphere.views[i].image.pixels.size(); ++p) {
                Rgb8& c = sphere.views[i].image.pixels[p];
                const auto lit = [&](std::uint8_t before) {
                    const double wave = std::sin(0.02 * static_cast<double>(p % 128) * static_cast<double>(i + 1));
                    return static_cast<std::uint8_t>(std::clamp(before + 60 * wave, 0.0, 255.0));
                };
                c = {lit(c.r), lit(c.g), lit(c.b)};
            }
        return sphere;
    }();
    return capture;
}

/// Of which a batch remembers most: the splits that the images rejected.
const ReconstructOptions small{.n_vertices = 1600, .n_coarse = 800, .follows_images = true};

struct Undisturbed {
    Recorder recorder;
    Journal journal{recorder};
    Undisturbed(const Capture& capture, const ReconstructOptions& options) {
        reconstruct(capture, options, recorder, {}, {}, &journal);
    }
};
const Undisturbed& undisturbed() {
    static const Undisturbed run(uneven_capture(), small);
    return run;
}

template <class T>
bool is_tail(const std::vector<T>& tail, const std::vector<T>& whole) {
    return tail.size() <= whole.size() &&
           std::equal(tail.begin(), tail.end(), whole.end() - static_cast<std::ptrdiff_t>(tail.size()));
}

void check_that_every_point_leads_to_the_end(const Undisturbed& whole, const Capture& capture,
                                             const ReconstructOptions& options) {
    for (std::size_t i = 0; i < whole.journal.points.size(); ++i) {
        const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 1 + i % 2);
        Recorder rest;
        Journal journal(rest);
        resume(capture, options, whole.journal.start, whole.journal.points[i], rest, {}, {}, journal);
        CHECK(rest.finished);
        CHECK(rest.hashes.size() == whole.journal.points.size() - 1 - i);
        CHECK(is_tail(rest.hashes, whole.recorder.hashes));
        CHECK(is_tail(rest.colours, whole.recorder.colours));
        CHECK(is_tail(rest.psi, whole.recorder.psi));
    }
}

}  // namespace

TEST_CASE("Resume: from every batch on, with any number of threads, the sink gets what an undisturbed run gave it") {
    const Undisturbed& whole = undisturbed();
    REQUIRE(!whole.journal.start.gains.empty());
    REQUIRE(!whole.journal.start.shifts.empty());
    REQUIRE(whole.journal.start.mask_growth_px > 1);
    REQUIRE(whole.journal.points.size() > 3);
    const bool has_rejected = std::ranges::any_of(whole.journal.points, [](const RefinementPoint& point) {
        return std::ranges::count(point.is_rejected, 1) > 0;
    });
    CHECK(has_rejected);
    check_that_every_point_leads_to_the_end(whole, uneven_capture(), small);
}

TEST_CASE("Resume: so it is where the batches approach the fitted surface, in the coarser steps of a noisy capture") {
    const ReconstructOptions approaching{.n_vertices = 1600, .n_coarse = 400};
    const Undisturbed whole(noisy_capture(), approaching);
    REQUIRE(whole.journal.points.size() > 3);
    CHECK(whole.recorder.state->rules().step_ratio < undisturbed().recorder.state->rules().step_ratio);
    check_that_every_point_leads_to_the_end(whole, noisy_capture(), approaching);
}

TEST_CASE("Resume: without a point the base comes once more") {
    const Undisturbed& whole = undisturbed();
    Recorder again;
    Journal journal(again);
    resume(uneven_capture(), small, whole.journal.start, std::nullopt, again, {}, {}, journal);
    CHECK(again.hashes == whole.recorder.hashes);
    CHECK(again.colours == whole.recorder.colours);
    CHECK(again.psi == whole.recorder.psi);
}

TEST_CASE("Resume: a run that is stopped and resumed again and again ends like an undisturbed one") {
    const Undisturbed& whole = undisturbed();
    Recorder recorder;
    Journal journal(recorder);
    for (int n_runs = 0; !recorder.finished; ++n_runs) {
        REQUIRE(n_runs <= static_cast<int>(whole.journal.points.size()));  // each gets a batch further
        std::stop_source stop;
        const auto stop_after_a_batch = [&](const Progress& p) {
            if (p.stage == Stage::refine && p.n_vertices > 0) stop.request_stop();
        };
        if (n_runs == 0)
            reconstruct(uneven_capture(), small, recorder, stop_after_a_batch, stop.get_token(), &journal);
        else
            resume(uneven_capture(), small, journal.start, journal.points.back(), recorder, stop_after_a_batch,
                   stop.get_token(), journal);
    }
    CHECK(recorder.hashes == whole.recorder.hashes);
    CHECK(recorder.psi == whole.recorder.psi);
}

TEST_CASE("Resume: a run that is stopped before its base gives the sink none") {
    for (const Stage stage : {Stage::hull, Stage::optimise}) {
        Recorder recorder;
        Journal journal(recorder);
        std::stop_source stop;
        const auto stop_there = [&](const Progress& p) {
            if (p.stage == stage) stop.request_stop();
        };
        CHECK(reconstruct(uneven_capture(), small, recorder, stop_there, stop.get_token(), &journal).stopped);
        CHECK(recorder.hashes.empty());
        CHECK_FALSE(recorder.finished);
    }
}

TEST_CASE("Resume: a capture with another number of views is refused") {
    const Undisturbed& whole = undisturbed();
    Capture fewer = uneven_capture();
    fewer.views.pop_back();
    Recorder recorder;
    Journal journal(recorder);
    CHECK_THROWS_AS(resume(fewer, small, whole.journal.start, whole.journal.points.front(), recorder, {}, {}, journal),
                    InputError);
}
