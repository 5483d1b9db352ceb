#include "core/progressive/emit_batch.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/progressive/cheapest_scalar.h"

namespace anyrate {
namespace {

/// Edges: no vertex moves further in one split. What wants to go on can do so in a later batch, and a needle's erratic
/// normal cannot throw a spike.
constexpr double longest_move = 0.5;

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

struct Target {
    std::optional<Vec3> place;
    double cost = 0;  ///< distortion per squared world unit off it
};

std::vector<Target> old_targets(const BatchTargets& targets, std::size_t n_more) {
    std::vector<Target> wanted;
    wanted.reserve(targets.old_vertices.size() + n_more);
    for (const Vec3& place : targets.old_vertices) wanted.push_back({place});
    for (std::size_t v = 0; v < targets.old_costs.size(); ++v) wanted[v].cost = targets.old_costs[v];
    return wanted;
}

}  // namespace

std::vector<SplitRecord> emit_batch(RefinableMesh& state, std::span<const std::int32_t> batch,
                                    const BatchTargets& targets, std::span<const std::int32_t> left_out,
                                    const Rounding& rounding) {
    assert(targets.old_vertices.size() == at(state.n_vertices()) && targets.new_vertices.size() == batch.size());
    assert(rounding.bit_price == 0 || (targets.old_costs.size() == targets.old_vertices.size() &&
                                       targets.new_costs.size() == targets.new_vertices.size()));
    std::vector<Target> wanted = old_targets(targets, 3 * batch.size());
    std::vector<SplitRecord> records;
    records.reserve(batch.size());
    const Grid grid = state.grid();
    const double steps_per_edge = state.rules().step_ratio, longest = longest_move * steps_per_edge;
    const auto choose = [&](const ScalarSite& site) -> std::int32_t {
        const Target& target = wanted[at(site.vertex)];
        if (!target.place) return 0;
        const Vec3 target_in_grid = (*target.place - grid.origin) / grid.unit;
        const double steps = (target_in_grid - site.position).dot(site.normal) / site.step;
        const double possible = std::clamp(steps, -longest, longest);
        const bool is_new = site.slot < 3;
        if (rounding.bit_price > 0) {
            const double step = site.step * grid.unit;
            return cheapest_scalar(possible, target.cost * step * step, rounding.bit_price, is_new);
        }
        if (!is_new && std::abs(steps) < rounding.dead_zone * steps_per_edge) return 0;
        return static_cast<std::int32_t>(std::lround(possible));
    };
    for (std::size_t k = 0; k < batch.size(); ++k) {
        if (!state.split_site(batch[k]) || std::ranges::binary_search(left_out, batch[k])) continue;
        for (std::size_t i = 0; i < 3; ++i) {
            Target& target = wanted.emplace_back();
            if (targets.new_vertices[k]) target.place = (*targets.new_vertices[k])[i];
            if (!targets.new_costs.empty()) target.cost = targets.new_costs[k][i];
        }
        records.push_back(state.split(batch[k], choose));
    }
    return records;
}

}  // namespace anyrate
