#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/progressive/emit_batch.h"
#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// A batch of splits with all scalars zero, made on a copy of the state: the mesh whose vertices are moved to where
/// they should go before the batch itself is emitted.
struct TrialBatch {
    Mesh mesh;
    std::vector<std::int32_t> first_new;  ///< per face of the batch: first of its three new vertices; -1: not split
    std::vector<std::int32_t> active;     ///< the nine vertices of every split, ascending
};

/// A face that a flip of an earlier split of the batch made unsplittable is passed over.
TrialBatch try_batch(const RefinableMesh& state, std::span<const std::int32_t> batch);

/// Where the vertices of the moved mesh stand, as emit_batch() takes it; no costs.
/// @param n_old  vertices of the state before the batch
BatchTargets targets_of(const TrialBatch& trial, std::int32_t n_old);

}  // namespace anyrate
