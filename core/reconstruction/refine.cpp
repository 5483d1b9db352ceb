#include "core/reconstruction/refine.h"

#include <numeric>
#include <optional>

#include "core/reconstruction/fitted_step.h"
#include "core/reconstruction/image_step.h"
#include "core/reconstruction/vertex_colours.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

bool has_room(const RefinableMesh& state, const RefineOptions& options) {
    return state.n_vertices() + 3 <= options.n_vertices;
}

/// Whether the next batch approaches the fitted surface whatever the images say of the state.
bool is_approaching(const RefinableMesh& state, const RefineOptions& options) {
    return !options.by_area && state.n_vertices() < options.n_approached;
}

/// The next batch.
/// @param now  of the state; gets its terms if they are needed
/// @return nullopt if nothing can be split, or on a stop
std::optional<RefinementStep> next_step(const RefinableMesh& state, StateDistortion& now, PhotoBackend& backend,
                                        const RefinementScene& scene, const RefineOptions& options,
                                        const std::stop_token& stop, std::vector<char>& is_rejected) {
    is_rejected.resize(at(state.n_faces()), 0);
    const bool is_credible = options.by_area || now.point.mean <= options.most_credible_psi;
    if (is_approaching(state, options) || !is_credible) return approach_fitted(state, scene, options);
    if (now.terms.empty()) now = measure_state(backend, state, options.samples_per_px);
    std::optional<RefinementStep> step = follow_images(state, now, backend, scene, options, stop, is_rejected);
    return step && !step->records.empty() ? std::move(step) : std::nullopt;
}

}  // namespace

std::vector<CurvePoint> refine(RefinableMesh& state, PhotoBackend& backend, const RefinementScene& scene,
                               const RefineOptions& options, ModelSink& sink,
                               const std::function<void(const CurvePoint&)>& progress, const std::stop_token& stop,
                               std::vector<char>* rejected) {
    StateDistortion now = measure_without_terms(backend, state, options.samples_per_px);
    std::vector<CurvePoint> curve{{state.n_vertices(), now.point.mean}};
    std::vector<char> none_rejected;
    std::vector<char>& is_rejected = rejected ? *rejected : none_rejected;
    while (has_room(state, options) && !stop.stop_requested()) {
        std::optional<RefinementStep> step = next_step(state, now, backend, scene, options, stop, is_rejected);
        if (!step) break;
        const std::int32_t n_before = state.n_vertices();
        state = std::move(step->state);
        now = step->distortion ? std::move(*step->distortion)
                               : measure_without_terms(backend, state, options.samples_per_px);
        curve.push_back({state.n_vertices(), now.point.mean});
        std::vector<std::int32_t> added(at(state.n_vertices() - n_before));
        std::iota(added.begin(), added.end(), n_before);
        const Mesh refined = state.to_mesh();
        sink.batch(step->records, state,
                   vertex_colours(scene.images, refined, vertex_spacing(refined, options.n_vertices), added),
                   now.point);
        if (progress) progress(curve.back());
    }
    return curve;
}

void refine_by_images(RefinableMesh& state, PhotoBackend& backend, const RefinementScene& scene,
                      const RefineOptions& options, const std::stop_token& stop) {
    StateDistortion now = measure_state(backend, state, options.samples_per_px);
    std::vector<char> is_rejected;
    while (has_room(state, options) && !stop.stop_requested()) {
        std::optional<RefinementStep> step = next_step(state, now, backend, scene, options, stop, is_rejected);
        if (!step) break;
        state = std::move(step->state);
        now = step->distortion ? std::move(*step->distortion)
                               : measure_without_terms(backend, state, options.samples_per_px);
    }
}

}  // namespace anyrate
