#pragma once
#include <functional>
#include <span>
#include <vector>

#include "core/reconstruction/depth_votes.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {

/// A scalar field on the nodes of a regular grid: node (i, j, k) stands at origin + spacing * (i, j, k) and is
/// values[(k * ny + j) * nx + i]. Negative inside the object.
struct ScalarField {
    int nx = 0, ny = 0, nz = 0;
    Vec3 origin = Vec3::Zero();
    double spacing = 1.0;
    std::vector<float> values;
};

struct PoissonOptions {
    double spacing = 0.0;    ///< world units
    double screening = 4.0;  ///< weight of the points' own positions against the smoothness of the field
    double vote = 0.2;  ///< weight of one certain vote on a node, likewise; 0.05: the floor deep in a pot, where two
                        ///< views look, is 6 % of the diagonal off instead of 4
    /// Certain votes that count on a node, whoever else sees it. If all did, the many views around thin parts would
    /// outvote their silhouettes: the Oxford dinosaur lost fingers.
    double most_votes = 2;
    int margin = 4;  ///< empty cells kept around the points, at least 2
};

/// Says what views see of the nodes of a row, which `votes` is as long as. Called from several threads.
using VoteFn = std::function<void(const NodeRow& row, RowVotes& votes)>;

/// The smoothed indicator function whose gradient fits the points' normals, each weighted by its point's area, shifted
/// so that its zero set passes through the points, and mapped by the inverse of the smoothing kernel's step: near the
/// surface the field is the distance in spacings, so that linear interpolation finds the surface; it ends at -1 inside
/// and +1 outside. Positive on the grid's border. The points should be no further apart than the spacing where the
/// surface is to follow them; gaps are closed smoothly, and away from what the votes call outside. Source: Kazhdan,
/// Bolitho, Hoppe 2006; screening after Kazhdan and Hoppe 2013; the votes are the data term of volumetric range fusion
/// (see depth_votes.h) with the same smoothness.
/// @param votes  asked for every row of nodes but those on the grid's border; or empty
/// @throws InputError if `points` is empty, or spans more than 2^28 nodes at this spacing
ScalarField poisson_field(std::span<const OrientedPoint> points, const PoissonOptions& options,
                          const VoteFn& votes = {});

}  // namespace anyrate
