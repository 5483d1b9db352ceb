#pragma once
#include <stop_token>

#include "core/progressive/model_sink.h"
#include "core/reconstruction/reconstruct.h"
#include "server/jobs/job_runner.h"

namespace anyrate {

/// The base of the small model, with its colours.
inline RefinableMesh write_octahedron(ModelSink& sink) {
    const BaseMesh octahedron{
        .positions = {{4096, 8192, 8192},
                      {12288, 8192, 8192},
                      {8192, 4096, 8192},
                      {8192, 12288, 8192},
                      {8192, 8192, 4096},
                      {8192, 8192, 12288}},
        .triangles = {{1, 3, 5}, {3, 0, 5}, {0, 2, 5}, {2, 1, 5}, {3, 1, 4}, {0, 3, 4}, {2, 0, 4}, {1, 2, 4}}};
    const Grid grid{.unit = 1.0 / 16384, .bits = 14, .base_shift = 2};
    const RefinementRules rules;
    RefinableMesh mesh(sink.start(grid, rules, octahedron), grid, rules);
    sink.base_attributes(std::vector<Rgb8>(6, Rgb8{200, 100, 50}), {.mean = 100, .max = 200});
    return mesh;
}

/// Splits face 0 until there are so many batches of one split.
/// @param after_batch  called behind each
inline void refine_small_model(
    RefinableMesh& mesh, ModelSink& sink, int n_batches, const std::function<void()>& after_batch = [] {}) {
    for (int i = (mesh.n_vertices() - 6) / 3; i < n_batches; ++i) {
        const SplitRecord record = mesh.split(0, [](const ScalarSite&) { return 0; });
        sink.batch({{record}}, mesh, std::vector<Rgb8>(3, Rgb8{50, 100, 200}),
                   {.mean = 100.0 / (i + 2), .max = 200.0 / (i + 2)});
        after_batch();
    }
    sink.finish();
}

/// Writes a model of one octahedron, refined by `n_batches` splits of face 0, to a sink: a stand-in for a
/// reconstruction that takes no time.
inline void write_small_model(ModelSink& sink, int n_batches) {
    RefinableMesh mesh = write_octahedron(sink);
    refine_small_model(mesh, sink, n_batches);
}

/// Job steps that need no capture and make that model, with a journal as a real job has it.
/// @param at_batch  called at the base and behind each batch, when the journal has it; may throw
inline JobSteps small_job_steps(
    int n_batches, const std::function<void(int n_vertices)>& at_batch = [](int) {}) {
    const auto journalled = [=](RefinableMesh& mesh, ModelSink& sink, RefinementJournal& journal) {
        refine_small_model(mesh, sink, n_batches, [&] {
            journal.batch(std::vector<char>(static_cast<std::size_t>(mesh.n_faces()), 1));
            at_batch(mesh.n_vertices());
        });
        return ReconstructResult{};
    };
    const auto from_the_base = [=](ModelSink& sink, RefinementJournal& journal) {
        RefinableMesh mesh = write_octahedron(sink);
        journal.batch({});
        at_batch(mesh.n_vertices());
        return journalled(mesh, sink, journal);
    };
    return {
        .load = [](const std::filesystem::path&) { return Capture{}; },
        .reconstruct =
            [=](const Capture&, const ReconstructOptions&, ModelSink& sink, const ProgressFn&, std::stop_token,
                RefinementJournal& journal) {
                journal.begin({});
                return from_the_base(sink, journal);
            },
        .resume =
            [=](const Capture&, const ReconstructOptions&, const RefinementStart&, std::optional<RefinementPoint> point,
                ModelSink& sink, const ProgressFn&, std::stop_token, RefinementJournal& journal) {
                return point ? journalled(point->state, sink, journal) : from_the_base(sink, journal);
            }};
}

}  // namespace anyrate
