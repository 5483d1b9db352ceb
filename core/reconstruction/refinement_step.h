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
    double growth = 0.16;        ///< vertices a batch adds, in parts of what is there; 0.12 is no better, 0.2 is worse
    double smallest_area = 0.2;  ///< faces below this part of the mean area are not split
    /// Of a state on which the images disagree more than this (squared colour units) they are no witness of what its
    /// vertices are to do: the splits approach the fitted surface instead. The Oxford dinosaur has 1,280, the synthetic
    /// captures 12 to 84. Its images followed, 58 faces of 10,000 vertices cut others, else none, and 20,000 vertices
    /// take 43 KB of geometry instead of 30.
    double most_credible_psi = 600;
    double approach_growth = 0.15;  ///< instead of `growth` there; pot at 5,000: with 0.2 2 % worse, 0.12 no better
    double bit_price = 0.25;        ///< there, see EncodeMeshOptions; pot at 5,000: with 0.5 1 % worse, 3 % less bytes
    int n_approached = 0;           ///< the splits approach it below this count, too, whatever the images say
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
