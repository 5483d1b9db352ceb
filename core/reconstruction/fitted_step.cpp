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
                                              const RefineOptions& options) {
    // A new one each time: what it remembered, a run that goes on here could not know.
    SurfaceMeter meter(scene.fitted, fewest_points);
    const MeasuredMesh measured = measure(state, meter);
    const std::vector<char> none_rejected(measured.faces.size(), 0);
    const double noise = noise_px * pixel_footprint(mean_vertex(measured.mesh), scene.images);
    RefinementStep step{state, {}, {}};
    step.records = approach(step.state,
                            split_scores(measured.mesh, distance_scores(measured, noise),
                                         scene.guessed.vertices(measured.mesh), none_rejected, options),
                            batch_size(state.n_vertices(), options.growth, options).taken, meter,
                            {.bit_price = options.bit_price * gain_of_a_bit(measured)});
    if (step.records.empty()) return std::nullopt;
    return step;
}

}  // namespace anyrate
