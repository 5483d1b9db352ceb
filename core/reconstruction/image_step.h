#pragma once
#include <optional>
#include <stop_token>
#include <vector>

#include "core/reconstruction/refinement_step.h"

namespace anyrate {

/// A batch of which the images say that it betters the surface, or if none is found, one that is taken as it is: the
/// count has to be met.
/// @param is_rejected  learns of the splits that did harm
/// @return nullopt if nothing can be split, or on a stop
std::optional<RefinementStep> follow_images(const RefinableMesh& state, const StateDistortion& now,
                                            PhotoBackend& backend, const RefinementScene& scene,
                                            const RefineOptions& options, const std::stop_token& stop,
                                            std::vector<char>& is_rejected);

}  // namespace anyrate
