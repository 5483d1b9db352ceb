#pragma once
#include <stop_token>

#include "core/mesh/mesh.h"
#include "core/reconstruction/guessed_surface.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/silhouette_term.h"

namespace anyrate {

struct ConfirmGuessOptions {
    int coarsest_level = 1;  ///< of the pyramid, where the guessed vertices start to move; later passes start finest
    int rounds = 2;          ///< a level
    /// Each starts from what the last one confirmed. Deep in the pot, which views from above see at a flat angle, the
    /// floor's rim is found ring by ring: over what any two of its 36 views see, 10,000 vertices are 0.051 % of the
    /// diagonal off with 2 passes, 0.036 with 3, 0.026 with 6.
    int passes = 6;
    int spreading_passes = 3;  ///< the first: a guess takes in what no two views see beside it; 6: bust 2 % worse
    double attachment = 3e-3;  ///< of a guess to its place, see fair(); 1e-2: pot 3 % worse, 1e-3: nefertiti 2 %
    double agreement = 25;     ///< largest G (Eq. 9) of a confirmed vertex, in medians over what is no guess
    double hopeless = 100;     ///< a shown vertex with a larger G, on trial too or hidden there, is a guess; same unit
};

/// Depth maps miss steep and narrow places that the photographs do agree on, and find some that they do not. Bends the
/// guessed parts, what the images disagree on and the ring around both as little as the rest allows, and lets those
/// vertices alone follow the images from there: a guess whose ring then agrees about as well as the rest is a guess no
/// longer; another stays one, as bent. What was no guess moves only to where the images agree better, never out of
/// their sight; where they are far from agreeing, before and after if they see it after, it becomes one. What no two
/// views see beside a guess is one as well, a ring further in every spreading pass: such surface, left where the hull
/// had it, stood five pixels below the bowl's belly and before what the views look at there (Psi of 10,000 vertices:
/// 15; now it is 7). What the images still disagree on after all passes is given other shapes and more vertices, see
/// mend_patches().
/// @param mesh  with edges of about one length; guessed and doubtful vertices move, and get others between them
/// @return what is left of the guess
GuessedSurface confirm_guesses(PhotoBackend& backend, Silhouettes& silhouettes, const GuessedSurface& guessed,
                               Mesh& mesh, const ConfirmGuessOptions& options = {}, const std::stop_token& stop = {});

}  // namespace anyrate
