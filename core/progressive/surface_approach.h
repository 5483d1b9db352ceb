#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/surface_meter.h"
#include "core/progressive/emit_batch.h"
#include "core/progressive/refinable_mesh.h"
#include "core/progressive/trial_batch.h"

namespace anyrate {

/// A decoded mesh and how far its faces are from a surface that batches of splits bring it nearer to.
struct MeasuredMesh {
    Mesh mesh;
    std::vector<FaceDistance> faces;
};

MeasuredMesh measure(const RefinableMesh& state, SurfaceMeter& meter);

/// Integral of the squared distance, world units to the fourth.
double squared_distance(const MeasuredMesh& now);

/// What a split of each face promises: its area times its root mean square distance. Area times mean square spends
/// splits on few bad faces, which often stay bad: a bust at 10,000 vertices takes 7 % more bytes then for the same mean
/// distance. A share of what the neighbours have, which the split bisects, brings nothing. Where the surface is off the
/// truth itself, a distance d adds to that as errors do which know nothing of each other, by sqrt(d^2 + noise^2) -
/// noise: within the noise hardly at all.
/// @param noise  of the surface that is approached, world units
/// @return one per face, world units cubed
std::vector<double> distance_scores(const MeasuredMesh& now, double noise = 0);

/// A batch as it would be with scalars of any size.
struct FittedBatch {
    TrialBatch trial;
    BatchTargets targets;  ///< with costs, world units to the fourth for a squared world unit
};

/// Splits the batch on a copy of the state and moves the nine vertices of every split, all together, to where the
/// squared distance is least.
FittedBatch fit_batch(const RefinableMesh& state, std::span<const std::int32_t> batch, SurfaceMeter& meter);

struct ApproachOptions {
    Rounding rounding;
    double noise = 0;       ///< see distance_scores()
    bool may_meet = false;  ///< whether faces may come to meet elsewhere than in what they share, as the surface's do
};

/// A batch, and what was learnt on the way to it.
struct ApproachStep {
    std::vector<SplitRecord> records;    ///< none if nothing can be split
    std::vector<std::int32_t> rejected;  ///< faces whose splits were tried and left out, ascending: they do harm
};

/// Splits the faces of the highest scores and has the vertices go as near to where fit_batch() wants them as their
/// scalars allow. More are tried than are split: a split turns edges and smooths around it, and where these were fitted
/// to the surface it may take the state further from it, whatever its scalars are. Of a pot's splits every third does,
/// and others nearby do not. It is left out as long as there are others, and so are splits that have faces meet.
/// @param now     measure() of the state
/// @param scores  one a face, see select_batch(); 0 for those that were rejected before
ApproachStep approach(RefinableMesh& state, const MeasuredMesh& now, std::span<const double> scores, int n_splits,
                      SurfaceMeter& meter, const ApproachOptions& options);

/// What a bit brings as part of a split, world units to the fourth: the squared distance falls about with the square of
/// the vertices, so that one more vertex of n lowers it by 2 / n of itself. What a few faces have beyond thirty times
/// the usual stays whatever is split, as in a crevice whose sides are taken for each other, and does not count: it
/// would make bits so dear that the whole surface is rounded (a bowl of 50,000 vertices: 0.0133 % of the diagonal off).
double gain_of_a_bit(const MeasuredMesh& now);

}  // namespace anyrate
