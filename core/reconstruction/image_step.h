#pragma once
#include <optional>
#include <span>
#include <stop_token>

#include "core/reconstruction/refinement_step.h"

namespace anyrate {

/// A batch of which the images say that it betters the surface, or if none is found, one that is taken as it is: the
/// count has to be met.
/// @param is_rejected  one flag a face; the step has those that this batch adds
/// @return nullopt if nothing can be split, or on a stop
std::optional<RefinementStep> follow_images(const RefinableMesh& state, const StateDistortion& now,
                                            PhotoBackend& backend, const RefinementScene& scene,
                                            const RefineOptions& options, const std::stop_token& stop,
                                            std::span<const char> is_rejected);

}  // namespace anyrate
