#include "core/reconstruction/fitted_step.h"

#include "core/mesh/surface_meter.h"
#include "core/progressive/surface_approach.h"
#include "core/reconstruction/pixel_footprint.h"

namespace anyrate {
namespace {

constexpr int fewest_points = 60'000;  ///< to measure a mesh by; with 40,000 the pot is up to 1 % worse
constexpr double noise_px = 0.05;      ///< of a surface that was fitted to good images; 0: pot at 5,000 1 % worse

Vec3 mean_vertex(const Mesh& mesh) {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& v : mesh.vertices) sum += v;
    return sum / mesh.n_vertices();
}

}  // namespace

std::optional<RefinementStep> approach_fitted(const RefinableMesh& state, const RefinementScene& scene,
                                              std::span<const char> is_rejected, const RefineOptions& options) {
    // A new one each time: what it remembered, a run that goes on here could not know.
    SurfaceMeter meter(scene.fitted, fewest_points);
    const MeasuredMesh now = measure(state, meter);
    const double noise = noise_px * pixel_footprint(mean_vertex(now.mesh), scene.images);
    RefinementStep step{state, {}, {}, {}};
    ApproachStep batch = approach(
        step.state, now,
        split_scores(now.mesh, distance_scores(now, noise), scene.guessed.vertices(now.mesh), is_rejected, options),
        batch_size(state.n_vertices(), options.growth, options).taken, meter,
        {.rounding = {.bit_price = options.bit_price * gain_of_a_bit(now)}, .noise = noise});
    if (batch.records.empty()) return std::nullopt;
    step.records = std::move(batch.records);
    step.rejected = std::move(batch.rejected);
    return step;
}

}  // namespace anyrate
