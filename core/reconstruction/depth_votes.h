#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/plane_sweep.h"

namespace anyrate {

/// What views say of the nodes of a regular lattice: node (i, j, k) stands at origin + spacing * (i, j, k) and is entry
/// (k * ny + j) * nx + i.
struct VoteField {
    int nx = 0, ny = 0, nz = 0;
    Vec3 origin = Vec3::Zero();
    double spacing = 1.0;
    std::vector<float> mean;    ///< of the votes, from -1, inside the object, to +1, outside
    std::vector<float> weight;  ///< the number of votes
};

struct VoteOptions {
    double spacing = 0;        ///< world units
    double truncation_px = 2;  ///< of disparity: further in front of the surface is outside; further behind, hidden
};

/// Every depth map votes on every node that it does not hide: by how far in front of its surface the node lies, cut off
/// at the truncation. Several views outvote a wrong one, and what many see through stays free.
/// Source: Curless and Levoy 1996, "A volumetric method for building complex models from range images".
/// @param lower, upper  of the box the lattice covers, world units
VoteField depth_votes(const Vec3& lower, const Vec3& upper, std::span<const DepthMap> maps, const VoteOptions& options);

}  // namespace anyrate
