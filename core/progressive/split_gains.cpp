#include "core/progressive/split_gains.h"

#include <algorithm>
#include <array>

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Adds `sign` times the cost of each face to the gains of the splits that it belongs to.
/// @param split_of  place in the batch of the split that has a vertex; -1: none has
void add(double sign, std::span<const double> costs, std::span<const Triangle> faces,
         std::span<const std::int32_t> split_of, std::vector<double>& gains) {
    for (std::size_t f = 0; f < faces.size(); ++f) {
        std::array<std::int32_t, 3> splits{};
        std::ranges::transform(faces[f], splits.begin(), [&](std::int32_t v) { return split_of[at(v)]; });
        std::ranges::sort(splits);
        const auto first = std::ranges::upper_bound(splits, -1);
        const auto end = std::unique(first, splits.end());
        for (auto split = first; split != end; ++split)
            gains[at(*split)] += sign * costs[f] / static_cast<double>(end - first);
    }
}

}  // namespace

std::vector<double> split_gains(const RefinableMesh& state, std::span<const std::int32_t> batch,
                                const TrialBatch& trial, const FaceCosts& costs) {
    std::vector<std::int32_t> split_of(trial.mesh.vertices.size(), -1);
    for (std::size_t k = 0; k < batch.size(); ++k) {
        if (trial.first_new[k] < 0) continue;
        for (std::int32_t i = 0; i < 3; ++i) split_of[at(trial.first_new[k] + i)] = static_cast<std::int32_t>(k);
        if (const auto site = state.split_site(batch[k]))
            for (const std::int32_t v : *site) split_of[at(v)] = static_cast<std::int32_t>(k);
    }
    std::vector<double> gains(batch.size(), 0.0);
    add(1, costs.before, state.triangles(), split_of, gains);
    add(-1, costs.after, trial.mesh.triangles, split_of, gains);
    return gains;
}

}  // namespace anyrate
