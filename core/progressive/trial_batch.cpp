#include "core/progressive/trial_batch.h"

#include <algorithm>

namespace anyrate {

TrialBatch try_batch(const RefinableMesh& state, std::span<const std::int32_t> batch) {
    RefinableMesh copy = state;
    TrialBatch trial;
    trial.first_new.assign(batch.size(), -1);
    for (std::size_t k = 0; k < batch.size(); ++k) {
        const auto site = copy.split_site(batch[k]);
        if (!site) continue;
        trial.first_new[k] = copy.n_vertices();
        trial.active.insert(trial.active.end(), site->begin(), site->end());
        copy.split(batch[k], [](const ScalarSite&) { return 0; });
        for (std::int32_t i = 0; i < 3; ++i) trial.active.push_back(trial.first_new[k] + i);
    }
    std::sort(trial.active.begin(), trial.active.end());
    trial.active.erase(std::unique(trial.active.begin(), trial.active.end()), trial.active.end());
    trial.mesh = copy.to_mesh();
    return trial;
}

BatchTargets targets_of(const TrialBatch& trial, std::int32_t n_old) {
    const std::vector<Vec3>& vertices = trial.mesh.vertices;
    BatchTargets targets;
    targets.old_vertices.assign(vertices.begin(), vertices.begin() + n_old);
    targets.new_vertices.resize(trial.first_new.size());
    for (std::size_t k = 0; k < trial.first_new.size(); ++k) {
        if (trial.first_new[k] < 0) continue;
        const auto v = static_cast<std::size_t>(trial.first_new[k]);
        targets.new_vertices[k] = {vertices[v], vertices[v + 1], vertices[v + 2]};
    }
    return targets;
}

}  // namespace anyrate
