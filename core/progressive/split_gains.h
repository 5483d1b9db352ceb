#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/progressive/refinable_mesh.h"
#include "core/progressive/trial_batch.h"

namespace anyrate {

/// What the faces of a mesh are worth, one value each, before a batch of splits and after it; less is better.
struct FaceCosts {
    std::span<const double> before, after;
};

/// By how much each split of a tried batch lowers the costs of the faces at its nine vertices. A face that has vertices
/// of several splits counts for all of them, in equal parts.
/// @param state  before the batch
/// @return one per face of the batch; 0 for one that was not split
std::vector<double> split_gains(const RefinableMesh& state, std::span<const std::int32_t> batch,
                                const TrialBatch& trial, const FaceCosts& costs);

}  // namespace anyrate
