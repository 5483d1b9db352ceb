#pragma once
#include <stop_token>

#include "core/mesh/mesh.h"
#include "core/reconstruction/guessed_surface.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/silhouette_term.h"

namespace anyrate {

struct ConfirmGuessOptions {
    int coarsest_level = 1;    ///< of the pyramid, where the guessed vertices start to move; later passes start finest
    int rounds = 3;            ///< a level
    int passes = 5;            ///< what one confirms is ground that the next starts from
    double attachment = 1e-4;  ///< of a guess to its place, see fair(); with 1e-2 bumps ten edges wide stay
    double agreement = 25;     ///< largest G (Eq. 9) of a confirmed vertex, in medians over what is no guess
    double hopeless = 100;     ///< a shown vertex with a larger G, on trial too or hidden there, is a guess; same unit
};

/// Depth maps miss steep and narrow places that the photographs do agree on, and find some that they do not. Bends the
/// guessed parts, what the images disagree on and the ring around both as little as the rest allows, and lets those
/// vertices alone follow the images from there: a guess whose ring then agrees about as well as the rest is a guess no
/// longer; another stays one, as bent. What was no guess moves only to where the images agree better, never out of
/// their sight; where they are far from agreeing, before and after if they see it after, it becomes one.
/// @param mesh  with edges of about one length; its guessed and doubtful vertices are moved
/// @return what is left of the guess
GuessedSurface confirm_guesses(PhotoBackend& backend, Silhouettes& silhouettes, const GuessedSurface& guessed,
                               Mesh& mesh, const ConfirmGuessOptions& options = {}, const std::stop_token& stop = {});

}  // namespace anyrate
