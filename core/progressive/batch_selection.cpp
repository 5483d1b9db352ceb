#include "core/progressive/batch_selection.h"

#include <algorithm>
#include <numeric>

namespace anyrate {

std::vector<std::int32_t> select_batch(const RefinableMesh& mesh, std::span<const double> scores, int n_splits) {
    std::vector<std::int32_t> order(scores.size());
    std::iota(order.begin(), order.end(), 0);
    std::erase_if(order, [&](std::int32_t f) { return !(scores[static_cast<std::size_t>(f)] > 0); });
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
        const double sa = scores[static_cast<std::size_t>(a)], sb = scores[static_cast<std::size_t>(b)];
        return sa != sb ? sa > sb : a < b;
    });
    std::vector<bool> taken(static_cast<std::size_t>(mesh.n_vertices()), false);
    std::vector<std::int32_t> batch;
    for (std::int32_t f : order) {
        if (static_cast<int>(batch.size()) == n_splits) break;
        const auto site = mesh.split_site(f);
        if (!site) continue;
        const auto is_taken = [&](std::int32_t v) { return taken[static_cast<std::size_t>(v)]; };
        if (std::any_of(site->begin(), site->end(), is_taken)) continue;
        for (std::int32_t v : *site) taken[static_cast<std::size_t>(v)] = true;
        batch.push_back(f);
    }
    std::sort(batch.begin(), batch.end());
    return batch;
}

}  // namespace anyrate
