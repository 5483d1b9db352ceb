#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/plane_sweep.h"

namespace anyrate {

/// Nodes of a regular grid that follow each other along the first axis.
struct NodeRow {
    Vec3 first;          ///< world units
    double spacing = 0;  ///< world units
};

/// What views say of the nodes of a row.
struct RowVotes {
    std::vector<float> sum;     ///< of the votes, each from -1, inside the object, to +1, outside, times its weight
    std::vector<float> weight;  ///< of all votes together
};

struct VoteOptions {
    double truncation_px = 2;  ///< of disparity: further in front of the surface is outside; further behind, hidden
};

/// Every depth map votes on every node that it does not hide: by how far in front of its surface the node lies, cut off
/// at the truncation. Several views outvote a wrong one, and what many see through stays free. A vote weighs as much as
/// the square of the images' agreement: where a surface is seen so flat that windows hardly agree, two views find the
/// same false depth, and no third is there to outvote them (from every second view of a bust, its crown was hollow).
/// Source: Curless and Levoy 1996, "A volumetric method for building complex models from range images".
/// @param maps   with the images' agreement, see confirm_depths()
/// @param votes  as long as the row; what is there is replaced
void depth_votes(std::span<const DepthMap> maps, const NodeRow& row, RowVotes& votes, const VoteOptions& options = {});

}  // namespace anyrate
