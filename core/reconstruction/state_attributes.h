#pragma once
#include <cstdint>
#include <vector>

#include "core/reconstruction/refinement_step.h"

namespace anyrate {

/// What a sink is given with a decoded state.
struct StateAttributes {
    DistortionPoint distortion;
    std::vector<Rgb8> colours;
};

/// Measures the state as measure_without_terms() does and colours its vertices from `first` on, side by side; whatever
/// the backend is asked, it is asked on the calling thread.
StateAttributes state_attributes(PhotoBackend& backend, const PhotoImages& images, const RefinableMesh& state,
                                 std::int32_t first, const RefineOptions& options);

/// The colours alone.
std::vector<Rgb8> state_colours(const PhotoImages& images, const RefinableMesh& state, std::int32_t first,
                                const RefineOptions& options);

}  // namespace anyrate
