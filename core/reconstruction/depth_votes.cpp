#include "core/reconstruction/depth_votes.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace anyrate {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// The nearest pixel's depth counts: between pixels on both sides of a depth edge there is no surface.
void vote(const DepthMap& map, const Vec3& x, double truncation_px, float& sum, float& n_votes) {
    if (!(x.z() > 0)) return;
    const double u = x.x() / x.z() + 0.5, v = x.y() / x.z() + 0.5;
    const auto& known = map.inverse_depth;
    if (!(u >= 0 && v >= 0 && u < known.width && v < known.height)) return;
    const double surface = known(static_cast<int>(u), static_cast<int>(v));
    if (!(surface > 0)) return;
    const double in_front_px = (1.0 / x.z() - surface) / map.step;
    if (in_front_px < -truncation_px) return;  // hidden
    sum += static_cast<float>(std::min(in_front_px / truncation_px, 1.0));
    n_votes += 1.0f;
}

}  // namespace

VoteField depth_votes(const Vec3& lower, const Vec3& upper, std::span<const DepthMap> maps,
                      const VoteOptions& options) {
    VoteField field;
    field.origin = lower;
    field.spacing = options.spacing;
    const Vec3 cells = ((upper - lower) / options.spacing).array().ceil();
    field.nx = static_cast<int>(cells.x()) + 1;
    field.ny = static_cast<int>(cells.y()) + 1;
    field.nz = static_cast<int>(cells.z()) + 1;
    field.mean.resize(at(field.nx) * at(field.ny) * at(field.nz));
    field.weight.resize(field.mean.size());
    parallel_for(
        at(field.ny) * at(field.nz),
        [&](std::size_t row) {
            const Vec3 start = lower + options.spacing * Vec3(0.0, static_cast<double>(row % at(field.ny)),
                                                              static_cast<double>(row / at(field.ny)));
            float* sum = field.mean.data() + row * at(field.nx);
            float* n_votes = field.weight.data() + row * at(field.nx);
            for (const DepthMap& map : maps) {
                if (!(map.step > 0)) continue;
                Vec3 x = map.P * start.homogeneous();
                const Vec3 step = options.spacing * map.P.col(0);
                for (std::size_t i = 0; i < at(field.nx); ++i, x += step)
                    vote(map, x, options.truncation_px, sum[i], n_votes[i]);
            }
            for (std::size_t i = 0; i < at(field.nx); ++i)
                if (n_votes[i] > 0) sum[i] /= n_votes[i];
        },
        1);
    return field;
}

}  // namespace anyrate
