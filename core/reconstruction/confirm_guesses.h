#pragma once
#include <stop_token>

#include "core/mesh/mesh.h"
#include "core/reconstruction/guessed_surface.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/silhouette_term.h"

namespace anyrate {

struct ConfirmGuessOptions {
    int coarsest_level = 1;  ///< of the pyramid, where the guessed vertices start to move
    int rounds = 3;          ///< a level
    int passes = 3;          ///< what one confirms is ground that the next starts from
    double agreement = 25;   ///< largest G (Eq. 9) of a confirmed vertex, in medians over what is no guess
};

/// Depth maps miss steep and narrow places that the photographs do agree on. Lets the guessed vertices alone follow the
/// images from an otherwise optimised surface: those whose ring then agrees about as well as the rest are a guess no
/// longer, the others go back to where they were.
/// @param mesh  with edges of about one length; its confirmed vertices are moved
/// @return what is left of the guess
GuessedSurface confirm_guesses(PhotoBackend& backend, Silhouettes& silhouettes, const GuessedSurface& guessed,
                               Mesh& mesh, const ConfirmGuessOptions& options = {}, const std::stop_token& stop = {});

}  // namespace anyrate
