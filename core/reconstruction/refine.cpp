#include "core/reconstruction/refine.h"

#include <optional>
#include <utility>

#include "core/parallel.h"
#include "core/reconstruction/fitted_step.h"
#include "core/reconstruction/image_step.h"
#include "core/reconstruction/state_attributes.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

bool has_room(const RefinableMesh& state, const RefineOptions& options) {
    return state.n_vertices() + 3 <= options.n_vertices;
}

/// The next batch.
/// @param now          of the state; gets its terms if they are needed
/// @param is_rejected  one flag a face
/// @return nullopt if nothing can be split, or on a stop
std::optional<RefinementStep> next_step(const RefinableMesh& state, StateDistortion& now, PhotoBackend& backend,
                                        const RefinementScene& scene, const RefineOptions& options,
                                        const std::stop_token& stop, std::span<const char> is_rejected) {
    if (!options.follows_images) return approach_fitted(state, scene, is_rejected, options);
    if (now.terms.empty()) now = measure_state(backend, state, options.samples_per_px);
    std::optional<RefinementStep> step = follow_images(state, now, backend, scene, options, stop, is_rejected);
    return step && !step->records.empty() ? std::move(step) : std::nullopt;
}

/// Gives the sink a batch, with colours of its new vertices and, if it is not known yet, the state's distortion.
/// @return of the state
StateDistortion send_batch(std::span<const SplitRecord> records, std::optional<StateDistortion> measured,
                           const RefinableMesh& state, PhotoBackend& backend, const RefinementScene& scene,
                           const RefineOptions& options, ModelSink& sink) {
    const std::int32_t first_new = state.n_vertices() - static_cast<std::int32_t>(3 * records.size());
    if (measured) {
        sink.batch(records, state, state_colours(scene.images, state, first_new, options), measured->point);
        return std::move(*measured);
    }
    const StateAttributes attributes = state_attributes(backend, scene.images, state, first_new, options);
    sink.batch(records, state, attributes.colours, attributes.distortion);
    return {attributes.distortion, {}};
}

}  // namespace

std::vector<CurvePoint> refine(RefinableMesh& state, PhotoBackend& backend, const RefinementScene& scene,
                               const RefineOptions& options, ModelSink& sink,
                               const std::function<void(const CurvePoint&)>& progress, const std::stop_token& stop,
                               std::vector<char>* rejected, std::optional<DistortionPoint> known) {
    StateDistortion now =
        known ? StateDistortion{*known, {}} : measure_without_terms(backend, state, options.samples_per_px);
    std::vector<CurvePoint> curve{{state.n_vertices(), now.point.mean}};
    std::vector<char> none_rejected;
    std::vector<char>& is_rejected = rejected ? *rejected : none_rejected;
    std::optional<RefinementStep> ahead;  // the batch that follows, if that is known before the state is measured
    is_rejected.resize(at(state.n_faces()), 0);
    while (has_room(state, options) && !stop.stop_requested()) {
        std::optional<RefinementStep> step = ahead ? std::exchange(ahead, std::nullopt)
                                                   : next_step(state, now, backend, scene, options, stop, is_rejected);
        if (!step) break;
        state = std::move(step->state);
        is_rejected.resize(at(state.n_faces()), 0);
        for (const std::int32_t face : step->rejected) is_rejected[at(face)] = 1;
        run_beside(
            [&] {
                if (has_room(state, options) && !options.follows_images)
                    ahead = approach_fitted(state, scene, is_rejected, options);
            },
            [&] {
                now = send_batch(step->records, std::move(step->distortion), state, backend, scene, options, sink);
                curve.push_back({state.n_vertices(), now.point.mean});
                if (progress) progress(curve.back());
            });
    }
    return curve;
}

}  // namespace anyrate
