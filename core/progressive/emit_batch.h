#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// Where the vertices of a batch of splits should go, world units.
struct BatchTargets {
    std::vector<Vec3> old_vertices;                                ///< all vertices before the batch
    std::vector<std::optional<std::array<Vec3, 3>>> new_vertices;  ///< per face of the batch; nullopt: where they fall

    // What it costs to miss them: distortion per squared world unit. Only asked for if bits have a price.
    std::vector<double> old_costs;
    std::vector<std::array<double, 3>> new_costs;
};

/// How the way to a target becomes a whole number of steps.
struct Rounding {
    double dead_zone = 0.01;  ///< edges: vertices from before the split that are nearer to their targets stay put
    double bit_price = 0;     ///< if above 0, distortion that a bit is worth: cheapest_scalar() decides instead
};

/// Splits the faces of the batch, each vertex going as near to its target as its scalar allows. A face that an earlier
/// split of the batch made unsplittable is passed over; one whose surroundings it turned moves what stands there now,
/// be it a vertex of the batch.
/// @param left_out  faces of the batch that are not split after all, ascending
std::vector<SplitRecord> emit_batch(RefinableMesh& state, std::span<const std::int32_t> batch,
                                    const BatchTargets& targets, std::span<const std::int32_t> left_out,
                                    const Rounding& rounding);

}  // namespace anyrate
