#include "core/reconstruction/semi_global.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace anyrate {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// The path costs of one row of pixels. Each pixel has a guard on either side of its planes, dearer than any path.
class PathRow {
public:
    static constexpr std::int16_t guard = std::numeric_limits<std::int16_t>::max() / 2;

    PathRow(int width, int n_planes)
        : stride_(at(n_planes) + 2), costs_(at(width) * stride_, guard), least_(at(width), no_path) {}

    std::int16_t* planes(int x) { return costs_.data() + at(x) * stride_ + 1; }
    const std::int16_t* planes(int x) const { return costs_.data() + at(x) * stride_ + 1; }
    bool has_path(int x) const { return least_[at(x)] != no_path; }
    std::int16_t least(int x) const { return least_[at(x)]; }
    void set_least(int x, std::int16_t least) { least_[at(x)] = least; }
    void end_path(int x) { least_[at(x)] = no_path; }

private:
    static constexpr std::int16_t no_path = -1;
    std::size_t stride_;
    std::vector<std::int16_t> costs_;
    std::vector<std::int16_t> least_;  // of each pixel's planes
};

// Hirschmueller 2008, Eq. 13, for all planes of a pixel. @return the least of them
std::int16_t extend_path(const std::uint8_t* cost, const std::int16_t* before, std::int16_t least_before, int n_planes,
                         const SemiGlobalOptions& options, std::int16_t* path, std::int16_t* sum) {
    const auto small_step = static_cast<std::int16_t>(options.small_step);
    const auto dearest = static_cast<std::int16_t>(least_before + options.large_step);
    std::int16_t least = PathRow::guard;
    for (int k = 0; k < n_planes; ++k) {
        const auto changed = static_cast<std::int16_t>(std::min(before[k - 1], before[k + 1]) + small_step);
        const std::int16_t cheapest = std::min(std::min(before[k], changed), dearest);
        path[k] = static_cast<std::int16_t>(cost[k] + cheapest - least_before);
        sum[k] = static_cast<std::int16_t>(sum[k] + path[k]);
        least = std::min(least, path[k]);
    }
    return least;
}

std::int16_t start_path(const std::uint8_t* cost, int n_planes, std::int16_t* path, std::int16_t* sum) {
    std::int16_t least = PathRow::guard;
    for (int k = 0; k < n_planes; ++k) {
        path[k] = cost[k];
        sum[k] = static_cast<std::int16_t>(sum[k] + path[k]);
        least = std::min(least, path[k]);
    }
    return least;
}

// Adds the costs of the paths that come from pixel (x - dx, y - dy).
void add_direction(const CostVolume& volume, const MaskImage& mask, const SemiGlobalOptions& options, int dx, int dy,
                   std::vector<std::int16_t>& sums) {
    PathRow before(volume.width, volume.n_planes), row(volume.width, volume.n_planes);
    for (int j = 0; j < volume.height; ++j) {
        const int y = dy < 0 ? volume.height - 1 - j : j;
        for (int i = 0; i < volume.width; ++i) {
            const int x = dx < 0 ? volume.width - 1 - i : i;
            if (mask(x, y) == 0) {
                row.end_path(x);
                continue;
            }
            const int from = x - dx;
            const PathRow& source = dy == 0 ? row : before;
            const bool goes_on = from >= 0 && from < volume.width && (dy == 0 || j > 0) && source.has_path(from);
            const std::size_t first = volume.first_plane(x, y);
            const std::uint8_t* cost = volume.costs.data() + first;
            std::int16_t* sum = sums.data() + first;
            row.set_least(x, goes_on ? extend_path(cost, source.planes(from), source.least(from), volume.n_planes,
                                                   options, row.planes(x), sum)
                                     : start_path(cost, volume.n_planes, row.planes(x), sum));
        }
        std::swap(before, row);
    }
}

}  // namespace

CostVolume::CostVolume(int w, int h, int n)
    : width(w), height(h), n_planes(n), costs(at(w) * at(h) * at(n), impossible) {}

std::vector<std::int16_t> semi_global_sums(const CostVolume& volume, const MaskImage& mask,
                                           const SemiGlobalOptions& options) {
    assert(mask.width == volume.width && mask.height == volume.height);
    std::vector<std::int16_t> sums(volume.costs.size(), 0);
    // Hirschmueller 2008, Eq. 14.
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (dx != 0 || dy != 0) add_direction(volume, mask, options, dx, dy, sums);
    return sums;
}

}  // namespace anyrate
