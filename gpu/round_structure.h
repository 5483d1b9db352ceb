#pragma once
#include <cstdint>
#include <vector>

#include "core/reconstruction/optimise_round.h"

namespace anyrate {

/// The connections of the mesh of a round as shaders/round.glsl reads them: who is active, which faces the images are
/// asked about, and the one-rings.
struct RoundStructure {
    std::vector<std::int32_t> head;   ///< counts, and where each list begins among the items
    std::vector<std::int32_t> items;  ///< the lists
};
RoundStructure round_structure(const OptimiseRound& round, std::size_t n_vertices);

}  // namespace anyrate
