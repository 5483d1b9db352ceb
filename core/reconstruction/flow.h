#pragma once
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/reconstruction/photo_backend.h"

namespace anyrate {

// Step 2 as the paper has it: explicit surface flow at a fixed rate, the baseline of its comparison (`--method flow`).
//   G    vertex distortion (Eq. 9)          N  outward unit normal       H  mean curvature
//   eta  half-width of Eq. 11's difference  dt time step (Eq. 4)         Gamma_min  shortest edge

struct FlowOptions {
    double eta = 0.25;            ///< of the shortest edge at the vertex, Eq. 11
    double courant = 0.25;        ///< bound of a step, in shortest edges at the vertex
    double tangential = 0.1;      ///< part of Eq. 12's step
    double samples_per_px = 1.0;  ///< C of Eq. 7
    int max_iterations = 60;
    int patience = 3;  ///< iterations without a fall of Psi after which it ends
};

/// Derivative of G along the normal by central difference, the ring resampled at both ends (Nghiem et al., Eq. 11).
/// `surface` must be the backend's current one.
/// @param half_width  eta Gamma_min of every vertex, world units
/// @return per vertex, squared colour units per world unit; nullopt where an end has no evidence
std::vector<std::optional<double>> normal_gradient(PhotoBackend& backend, const SurfaceView& surface,
                                                   const OneRings& rings, std::span<const Vec3> normals,
                                                   std::span<const double> half_width);

/// One explicit step of the flow dS/dt = (G H + <grad G, N>) N (Nghiem et al., Eqs. 3 and 4), signed so that G falls
/// and curvature shrinks. The time step is the largest for which nine vertices of ten stay within their Courant bound;
/// the others are cut to it.
/// @return the displacement of every vertex, world units
std::vector<Vec3> flow_step(std::span<const std::optional<double>> G, std::span<const std::optional<double>> gradient,
                            std::span<const Vec3> curvature_normals, std::span<const Vec3> normals,
                            std::span<const double> bounds);

/// The loop: visibility, Eq. 4, Eq. 12, until Psi no longer falls; the vertices end at the lowest Psi met.
/// @param progress hears the iteration and Psi, as the flow samples it, while `vertices` are those of the iteration
void surface_flow(PhotoBackend& backend, std::vector<Vec3>& vertices, std::span<const Triangle> triangles,
                  const FlowOptions& options, const std::function<void(int, double)>& progress = {},
                  const std::stop_token& stop = {});

}  // namespace anyrate
