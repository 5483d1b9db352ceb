#pragma once
#include <optional>
#include <span>

#include "core/reconstruction/refinement_step.h"

namespace anyrate {

/// A batch that takes the state nearer to the fitted surface, whatever the images say of it: they are not asked.
/// @param is_rejected  one flag a face; the step has those that this batch adds
/// @return not measured; nullopt if nothing can be split
std::optional<RefinementStep> approach_fitted(const RefinableMesh& state, const RefinementScene& scene,
                                              std::span<const char> is_rejected, const RefineOptions& options);

}  // namespace anyrate
