#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// Picks the faces of the next batch: the highest scores first, as long as they can be split and no vertex that one
/// split moves is moved by another, so that the splits are independent of each other (spec: batches). Ties go to the
/// lower id.
/// @param scores  one per face; a face of score 0 or less is never taken
/// @return face ids, ascending; at most `n_splits`
std::vector<std::int32_t> select_batch(const RefinableMesh& mesh, std::span<const double> scores, int n_splits);

}  // namespace anyrate
