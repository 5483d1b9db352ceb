#include "core/reconstruction/depth_votes.h"

#include <algorithm>
#include <cmath>

namespace anyrate {
namespace {

// The nearest pixel's depth counts: between pixels on both sides of a depth edge there is no surface.
void vote(const DepthMap& map, const Vec3& x, double truncation_px, float& sum, float& weight) {
    if (!(x.z() > 0)) return;
    const double u = x.x() / x.z() + 0.5, v = x.y() / x.z() + 0.5;
    const auto& known = map.inverse_depth;
    if (!(u >= 0 && v >= 0 && u < known.width && v < known.height)) return;
    const int column = static_cast<int>(u), line = static_cast<int>(v);
    const double surface = known(column, line);
    if (!(surface > 0)) return;
    const double in_front_px = (1.0 / x.z() - surface) / map.step;
    if (in_front_px < -truncation_px) return;  // hidden
    const float agreement = map.agreement(column, line), of_vote = agreement * agreement;
    sum += of_vote * static_cast<float>(std::min(in_front_px / truncation_px, 1.0));
    weight += of_vote;
}

}  // namespace

void depth_votes(std::span<const DepthMap> maps, const NodeRow& row, RowVotes& votes, const VoteOptions& options) {
    std::ranges::fill(votes.sum, 0.0f);
    std::ranges::fill(votes.weight, 0.0f);
    for (const DepthMap& map : maps) {
        if (!(map.step > 0)) continue;
        Vec3 x = map.P * row.first.homogeneous();
        const Vec3 step = row.spacing * map.P.col(0);
        for (std::size_t i = 0; i < votes.sum.size(); ++i, x += step)
            vote(map, x, options.truncation_px, votes.sum[i], votes.weight[i]);
    }
}

}  // namespace anyrate
