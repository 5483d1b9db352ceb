#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/true_surface.h"
#include "core/progressive/model_sink.h"
#include "core/progressive/refinable_mesh.h"
#include "core/reconstruction/guessed_surface.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/silhouette_term.h"

namespace anyrate {

struct RefineOptions {
    int n_vertices = 10'000;
    double smallest_area = 0.2;  ///< faces below this part of the mean area are not split
    double growth = 0.15;     ///< vertices a batch adds, in parts of what is there; 0.2: pot 2 % worse, 0.12 the same
    double bit_price = 0.15;  ///< see EncodeMeshOptions; 0.25: pot at 7,500 1 % worse, all 1 % less bytes
    bool follows_images = false;    ///< as the paper's splits do, instead of approaching the fitted surface
    double followed_growth = 0.16;  ///< instead of `growth` then; 0.12 is no better, 0.2 is worse
    bool by_area = false;           ///< split the largest faces instead of the most promising (`--method uniform`)
    double samples_per_px = 1.0;
};

/// What step 3 looks at.
struct RefinementScene {
    const PhotoImages& images;
    Silhouettes& silhouettes;
    const GuessedSurface& guessed;
    /// A finer surface that the images have been asked about already.
    const TrueSurface& fitted;
};

/// Distortion of the decoded state as it stands, over the whole surface at the photographs' own resolution.
struct StateDistortion {
    DistortionPoint point;
    std::vector<TriangleTerms> terms;  ///< one per face; none if they were not asked for
};
/// @param samples_per_px  C of Eq. 7 (Nghiem et al.), per pixel of the photographs
StateDistortion measure_state(PhotoBackend& backend, const RefinableMesh& state, double samples_per_px);
/// The point of a surface that is the backend's current one already.
DistortionPoint current_distortion(PhotoBackend& backend, const SurfaceView& surface);
/// The same point, without derivatives.
StateDistortion measure_without_terms(PhotoBackend& backend, const RefinableMesh& state, double samples_per_px);

/// A decoded state, what led to it and what the images say of it.
struct RefinementStep {
    RefinableMesh state;
    std::vector<SplitRecord> records;
    std::optional<StateDistortion> distortion;  ///< nullopt: the images were not asked yet
    std::vector<std::int32_t> rejected;  ///< faces of the state before, whose splits did harm where they were tried
};

/// How many splits a batch tries, and how many of them it takes at most.
struct BatchSize {
    int tried = 0, taken = 0;
};
/// @param growth  vertices a batch adds, in parts of what is there, but for what makes the last one as large as others
BatchSize batch_size(int n_vertices, double growth, const RefineOptions& options);

/// What a split of each face promises; 0 for a face that is not to be split.
/// @param scores  what the evidence says; for guesses nothing is evidence
std::vector<double> split_scores(const Mesh& mesh, std::vector<double> scores, std::span<const char> is_guessed,
                                 std::span<const char> is_rejected, const RefineOptions& options);

}  // namespace anyrate
