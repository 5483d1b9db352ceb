#include "core/progressive/emit_batch.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace anyrate {
namespace {

/// No vertex moves further in one split than about half an edge (edge / 80 is a step): what wants to go on can do so in
/// a later batch, and a needle's erratic normal cannot throw a spike.
constexpr double largest_scalar = 40;

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace

std::vector<SplitRecord> emit_batch(RefinableMesh& state, std::span<const std::int32_t> batch,
                                    const BatchTargets& targets, std::span<const std::int32_t> left_out,
                                    double dead_zone) {
    assert(targets.old_vertices.size() == at(state.n_vertices()) && targets.new_vertices.size() == batch.size());
    std::vector<std::optional<Vec3>> wanted(targets.old_vertices.begin(), targets.old_vertices.end());
    std::vector<SplitRecord> records;
    records.reserve(batch.size());
    const Grid grid = state.grid();
    const auto choose = [&](const ScalarSite& site) -> std::int32_t {
        const std::optional<Vec3>& target = wanted[at(site.vertex)];
        if (!target) return 0;
        const Vec3 target_in_grid = (*target - grid.origin) / grid.unit;
        const double steps = (target_in_grid - site.position).dot(site.normal) / site.step;
        if (const bool is_new = site.slot < 3; !is_new && std::abs(steps) < dead_zone) return 0;
        return static_cast<std::int32_t>(std::lround(std::clamp(steps, -largest_scalar, largest_scalar)));
    };
    for (std::size_t k = 0; k < batch.size(); ++k) {
        if (!state.split_site(batch[k]) || std::ranges::binary_search(left_out, batch[k])) continue;
        for (std::size_t i = 0; i < 3; ++i)
            wanted.push_back(targets.new_vertices[k] ? std::optional((*targets.new_vertices[k])[i]) : std::nullopt);
        records.push_back(state.split(batch[k], choose));
    }
    return records;
}

}  // namespace anyrate
