#include "core/reconstruction/refine.h"

#include <numeric>
#include <optional>

#include "core/reconstruction/fitted_step.h"
#include "core/reconstruction/image_step.h"
#include "core/reconstruction/vertex_colours.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace

std::vector<CurvePoint> refine(RefinableMesh& state, PhotoBackend& backend, const RefinementScene& scene,
                               const RefineOptions& options, ModelSink& sink,
                               const std::function<void(const CurvePoint&)>& progress, const std::stop_token& stop,
                               std::vector<char>* rejected) {
    StateDistortion now = measure_state(backend, state, options.samples_per_px);
    std::vector<CurvePoint> curve{{state.n_vertices(), now.point.mean}};
    std::vector<char> none_rejected;
    std::vector<char>& is_rejected = rejected ? *rejected : none_rejected;
    while (state.n_vertices() + 3 <= options.n_vertices && !stop.stop_requested()) {
        is_rejected.resize(at(state.n_faces()), 0);
        const bool is_credible = options.by_area || now.point.mean <= options.most_credible_psi;
        std::optional<RefinementStep> step = is_credible
                                                 ? follow_images(state, now, backend, scene, options, stop, is_rejected)
                                                 : approach_fitted(state, backend, scene, options);
        if (!step || step->records.empty()) break;
        const std::int32_t n_before = state.n_vertices();
        state = std::move(step->state);
        now = std::move(step->distortion);
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

}  // namespace anyrate
