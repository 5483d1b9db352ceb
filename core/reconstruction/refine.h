#pragma once
#include <functional>
#include <stop_token>

#include "core/mesh/true_surface.h"
#include "core/progressive/model_sink.h"
#include "core/reconstruction/guessed_surface.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/reconstruct.h"
#include "core/reconstruction/silhouette_term.h"

namespace anyrate {

struct RefineOptions {
    int n_vertices = 10'000;
    double growth = 0.16;        ///< vertices a batch adds, in parts of what is there; 0.12 is no better, 0.2 is worse
    double smallest_area = 0.2;  ///< faces below this part of the mean area are not split
    double dead_zone = 0.75;     ///< updates of old vertices below this many steps are not sent
    /// Of a state on which the images disagree this much (squared colour units) they are no witness of what its
    /// vertices are to do: the splits approach the fitted surface instead.
    double most_credible_psi = 600;
    double bit_price = 0.5;  ///< there, see EncodeMeshOptions
    bool by_area = false;    ///< split the largest faces instead of the most promising (`--method uniform`)
    double samples_per_px = 1.0;
};

/// What step 3 looks at.
struct RefinementScene {
    const PhotoImages& images;
    Silhouettes& silhouettes;
    const GuessedSurface& guessed;
    /// A finer surface that the images have been asked about already: new vertices start there, and where it leaves a
    /// face, a split is expected to pay even if the images, compared across the gap, do not say so.
    const TrueSurface& fitted;
};

/// Distortion of the decoded state as it stands, over the whole surface at the photographs' own resolution.
struct StateDistortion {
    DistortionPoint point;
    std::vector<TriangleTerms> terms;  ///< one per face
    std::vector<double> pixel_sizes;   ///< one per face: of a pixel of the photographs there, world units
};
StateDistortion measure_state(PhotoBackend& backend, const RefinableMesh& state, double samples_per_px);

/// Step 3 of the method: until the rate is met, splits the faces where a split is expected to lower the distortion
/// most, optimises the three new and six old vertices of every split of the batch together, and writes what the decoder
/// will see. The state is always the decoded one (closed loop). Differs from the paper, which takes one triangle of
/// largest phi at a time: a batch of independent splits (parallel, and cheap to encode), ranked by the decrease that
/// moving the three middles is expected to bring, since phi alone stays high at texture edges that no split can mend.
/// Where the images disagree too much to be followed that far (RefineOptions::most_credible_psi), batches bring the
/// state nearer to the fitted surface, which is smoother than they are and knows the silhouettes.
/// @param rejected  one flag a face whose split the images did not bear out: all that is remembered from batch to
///                  batch besides the state. Whoever gives state and flags as they were after a batch gets the batches
///                  that would have followed, bit for bit.
/// @return the curve, the state's own point first
std::vector<CurvePoint> refine(RefinableMesh& state, PhotoBackend& backend, const RefinementScene& scene,
                               const RefineOptions& options, ModelSink& sink,
                               const std::function<void(const CurvePoint&)>& progress, const std::stop_token& stop,
                               std::vector<char>* rejected = nullptr);

}  // namespace anyrate
