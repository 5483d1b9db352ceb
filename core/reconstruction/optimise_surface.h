#pragma once
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/reconstruction/normal_displacement.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/silhouette_term.h"

namespace anyrate {

struct OptimiseOptions {
    int level = 0;                     ///< of the image pyramid
    double samples_per_px = 1.0;       ///< C of Eq. 7, per pixel of that level
    int rounds = 3;                    ///< visibility is rendered once a round; more where RoundOutcome::is_faint
    int steps_per_round = 3;           ///< the last is not looked at
    double max_step_px = 1.0;          ///< no vertex moves further in one step, pixels of the level
    double tangential = 0.3;           ///< part of Eq. 12's step taken after each round, 0 none
    double silhouette_reach_px = 3.0;  ///< see Silhouettes::terms()
    double bending = 0.04;             ///< weight of a vertex's squared umbrella, in parts of the mean curvature of phi
    /// Weight of a squared pixel, per pixel of contour, in parts of psi, or of a clean surface's. With 0.3 masks that
    /// are two pixels too small cost nefertiti 63 % of its accuracy, with 0.12 a third.
    double silhouette = 0.12;
};

/// Step 2 at a fixed rate: moves the active vertices along their normals to where the images agree most, by damped
/// Gauss-Newton steps on phi (robust_terms.h) + silhouettes + bending, each but a round's last accepted only if that
/// energy falls, else rolled back and damped more; between rounds vertices slide tangentially (Nghiem et al., Eq. 12)
/// and visibility is rendered anew. All lengths are pixels or local edges, so there is no time step to choose. Differs
/// from the paper's explicit flow (flow.h) in the step only: the same Eqs. 5-10 are minimised, with the derivative
/// taken analytically instead of by Eq. 11, which remains its test.
/// @param active      vertices that may move, ascending; empty is all
/// @param is_guessed  one flag a vertex, or empty: what the images show at a face with a flagged corner is not the face
/// @return whether anything moved
bool optimise_surface(PhotoBackend& backend, Silhouettes& silhouettes, std::vector<Vec3>& vertices,
                      std::span<const Triangle> triangles, std::span<const std::int32_t> active,
                      std::span<const char> is_guessed, const OptimiseOptions& options,
                      const std::stop_token& stop = {});

}  // namespace anyrate
