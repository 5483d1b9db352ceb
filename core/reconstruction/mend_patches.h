#pragma once
#include <stop_token>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/reconstruction/face_distortions.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/silhouette_term.h"

namespace anyrate {

/// Gives what the images disagree on other shapes, see replace_patches(), and more vertices to have them with: first by
/// the mesh as it is, then with every edge halved where images still disagree or a guess is left, last from places
/// further in and further out. The folds of an ear are as wide as the even mesh's edges (nefertiti, 10,000 vertices:
/// 0.0146 % of the diagonal off without halved edges, 0.0143 with them, at most 0.80 and 0.74 %; with a tenth of the
/// texture 0.0204 and 0.0198 %).
/// @param distortions  of `mesh`
/// @param level        of the pyramid, where the mesh as it is starts to move
/// @param is_guessed   one flag a vertex, before and after
/// @param mesh         with edges of about one length; afterwards some have half of it
void mend_patches(PhotoBackend& backend, Silhouettes& silhouettes, FaceDistortions distortions, int level,
                  std::vector<char>& is_guessed, Mesh& mesh, const std::stop_token& stop = {});

}  // namespace anyrate
