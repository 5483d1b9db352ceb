#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/reconstruction/optimise_surface.h"
#include "core/reconstruction/silhouette_term.h"

namespace anyrate {

/// What a round of optimise_surface() works on; PhotoBackend::optimise_round() takes it.
struct OptimiseRound {
    std::span<const Triangle> triangles;
    const OneRings& rings;
    std::span<const std::int32_t> active;  ///< vertices that may move, ascending, with a face each
    std::span<const std::int32_t> around;  ///< all faces around them, ascending
    std::span<const std::int32_t> faces;   ///< those of them that the images are asked about
    const OptimiseOptions& options;
    Silhouettes& silhouettes;
    /// Whether the silhouettes have yet to look at the surface; else they go by what they saw in the call before.
    bool is_first = true;
};

/// The constants of a round, for who computes it elsewhere than on the CPU (optimise_surface.cpp says how they came
/// about).
struct RoundRules {
    int most_trials;        ///< of a step
    double more_damping;    ///< a refused trial's damping is multiplied by this
    double less_damping;    ///< a taken step's is divided by this
    double least_damping;   ///< and never falls below this
    double max_step_edges;  ///< longest step, mean edges around the vertex
    double clean_psi;       ///< squared colour units
    double noise_psi;       ///< squared colour units
    double outlier;         ///< usual distortions, see credible_distortion()
    double noisy_psi;       ///< squared colour units
    double noisy_bending;   ///< in parts of the mean curvature of phi
    double weak_evidence;   ///< in parts of the mean curvature of phi
    double converged;       ///< in parts of the energy
};
RoundRules round_rules();

/// @param pixel_size  of a face, world units: PhotoBackend::pixel_size()
/// @return one per active vertex: its mean over the faces around
std::vector<double> pixels_around(const OptimiseRound& round, const std::function<double(std::int32_t)>& pixel_size);

/// What noise alone makes of the curvature of phi along a normal.
/// @param pixels  of the active vertices, world units; not empty
/// @return a sample, squared colour units per squared world unit
double least_curvature(std::span<const double> pixels);

}  // namespace anyrate
