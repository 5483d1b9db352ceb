#pragma once
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/reconstruction/face_distortions.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/silhouette_term.h"

namespace anyrate {

struct PatchOptions {
    int level = 1;      ///< of the pyramid, where the patches start to move
    int rounds = 3;     ///< a level; 6: cropped photographs come as near, for 8 % more of the pot's time
    double doubt = 25;  ///< least G (Eq. 9) of a vertex that patches grow from, in medians over no guesses
    int n_rings = 2;    ///< that they grow by
    /// Mean edges that the middle of a patch is pushed outwards to start from, its rings less and less. None: it starts
    /// bent as little as the rest allows.
    std::optional<double> push = {};
    double most_distortion = 0.95;  ///< mean of a patch that replaces another, in parts of that one's
    double least_evidence = 0.5;    ///< samples that it is seen at, in parts of those before: hidden is not better
};

/// Flags the vertices that two views or more see, and that are guesses or disagree.
/// @param G      Eq. 9, squared colour units
/// @param doubt  least G, in medians over no guesses
/// @return one a vertex; none is flagged where there is no median
std::vector<char> doubtful_or_guessed(std::span<const std::optional<double>> G, std::span<const char> is_guessed,
                                      double doubt);

/// Where single vertices cannot agree with the images whatever they do, what is wrong may be the shape: a web between
/// an ear and the head behind it, a flap that a hull's lid has left. Grows patches around the vertices that are seen
/// but doubtful or guessed, bends each as little as the rest allows, whatever it looked like, or pushes it out of the
/// hollow of the energy that it rests in, and lets them follow the images from there. A patch whose images then agree
/// better, by the mean of its faces' robust distortions, replaces what was there as a whole; guesses in it that agree
/// about as well as the rest are guesses no longer.
/// @param distortions  of `mesh`, before and after
/// @param is_guessed   one flag a vertex
/// @param mesh         with edges of about one length in each patch
void replace_patches(PhotoBackend& backend, Silhouettes& silhouettes, const OneRings& rings,
                     FaceDistortions& distortions, std::span<char> is_guessed, Mesh& mesh, const PatchOptions& options,
                     const std::stop_token& stop = {});

}  // namespace anyrate
