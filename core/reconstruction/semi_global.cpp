#include "core/reconstruction/semi_global.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>

namespace anyrate {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Eight planes of a pixel, in a register of any x86-64 or ARM.
using Short8 = std::int16_t __attribute__((vector_size(16)));
using Byte8 = std::uint8_t __attribute__((vector_size(8)));
static_assert(CostVolume::lanes == sizeof(Short8) / sizeof(std::int16_t));

template <class Lanes, class T>
void load(const T* from, Lanes& lanes) {
    std::memcpy(&lanes, from, sizeof lanes);
}

// The path costs of one row of pixels. A pixel has all planes here; those outside its range are dearer than any path.
class PathRow {
public:
    static constexpr std::int16_t guard = std::numeric_limits<std::int16_t>::max() / 2;

    PathRow(int width, int n_planes)
        : stride_(at(n_planes + 2 + CostVolume::lanes)), costs_(at(width) * stride_, guard), slots_(at(width)) {}

    const std::int16_t* planes(int x) const { return costs_.data() + at(x) * stride_ + 1; }
    bool has_path(int x) const { return slots_[at(x)].n > 0; }
    std::int16_t least(int x) const { return slots_[at(x)].least; }

    // Forgets the pixel's path. @return where the costs of the new one go, its first plane's first
    std::int16_t* restart(int x, const CostVolume::Range& range) {
        Slot& slot = slots_[at(x)];
        std::int16_t* planes = costs_.data() + at(x) * stride_ + 1;
        std::fill_n(planes + slot.first, slot.n, guard);
        slot.first = range.first;
        slot.n = range.n;
        return planes + range.first;
    }
    void set_least(int x, std::int16_t least) { slots_[at(x)].least = least; }

private:
    struct Slot {
        std::int32_t first = 0, n = 0;  // planes that have a path
        std::int16_t least = 0;         // of their costs
    };
    std::size_t stride_;
    std::vector<std::int16_t> costs_;
    std::vector<Slot> slots_;
};

std::int16_t least_of(const Short8& lanes) {
    std::int16_t least = lanes[0];
    for (int i = 1; i < CostVolume::lanes; ++i) least = std::min<std::int16_t>(least, lanes[i]);
    return least;
}

// Hirschmueller 2008, Eq. 13, for all planes of a pixel.
// @param before  of the pixel that the path comes from, at this one's first plane; nullptr where a path starts
// @return the least of them
std::int16_t extend_path(const std::uint8_t* cost, int n_planes, const std::int16_t* before, std::int16_t least_before,
                         const SemiGlobalOptions& options, std::int16_t* path, std::int16_t* sum) {
    const Short8 zero{}, guard = zero + PathRow::guard;
    const Short8 dearest = zero + static_cast<std::int16_t>(least_before + options.large_step);
    const auto small_step = static_cast<std::int16_t>(options.small_step);
    Short8 least = guard;
    for (int k = 0; k < n_planes; k += CostVolume::lanes) {
        Byte8 bytes;
        load(cost + k, bytes);
        const Short8 own = __builtin_convertvector(bytes, Short8);
        Short8 costs = own;
        if (before != nullptr) {
            Short8 same, lower, upper;
            load(before + k, same);
            load(before + k - 1, lower);
            load(before + k + 1, upper);
            const Short8 changed = (lower < upper ? lower : upper) + small_step;
            Short8 cheapest = same < changed ? same : changed;
            cheapest = cheapest < dearest ? cheapest : dearest;
            costs = own + cheapest - least_before;
        }
        const Short8 is_plane = own != static_cast<std::int16_t>(CostVolume::impossible);
        costs = is_plane ? costs : guard;
        least = costs < least ? costs : least;
        std::memcpy(path + k, &costs, sizeof costs);
        Short8 sums;
        load(sum + k, sums);
        sums += is_plane ? costs : zero;
        std::memcpy(sum + k, &sums, sizeof sums);
    }
    return least_of(least);
}

// Adds the costs of the paths that come from pixel (x - dx, y - dy).
void add_direction(const CostVolume& volume, const SemiGlobalOptions& options, int dx, int dy,
                   std::vector<std::int16_t>& sums) {
    PathRow before(volume.width, volume.n_planes), row(volume.width, volume.n_planes);
    for (int j = 0; j < volume.height; ++j) {
        const int y = dy < 0 ? volume.height - 1 - j : j;
        for (int i = 0; i < volume.width; ++i) {
            const int x = dx < 0 ? volume.width - 1 - i : i;
            const CostVolume::Range& range = volume.at(x, y);
            std::int16_t* path = row.restart(x, range);
            if (range.n == 0) continue;
            const int from = x - dx;
            const PathRow& source = dy == 0 ? row : before;
            const bool goes_on = from >= 0 && from < volume.width && (dy == 0 || j > 0) && source.has_path(from);
            row.set_least(x, extend_path(volume.costs.data() + range.start, range.n,
                                         goes_on ? source.planes(from) + range.first : nullptr,
                                         goes_on ? source.least(from) : std::int16_t{0}, options, path,
                                         sums.data() + range.start));
        }
        std::swap(before, row);
    }
}

}  // namespace

CostVolume::CostVolume(int n, const Image<std::int16_t>& first, const Image<std::int16_t>& last)
    : width(first.width), height(first.height), n_planes(n), ranges(first.pixels.size()) {
    assert(last.width == width && last.height == height);
    std::size_t end = 0;
    for (std::size_t p = 0; p < ranges.size(); ++p) {
        if (first.pixels[p] > last.pixels[p]) continue;
        ranges[p] = {first.pixels[p], last.pixels[p] - first.pixels[p] + 1, end};
        end += static_cast<std::size_t>((ranges[p].n + lanes - 1) / lanes * lanes);
    }
    costs.assign(end, impossible);
    for (const Range& range : ranges) std::fill_n(costs.data() + range.start, range.n, worst_cost);
}

std::vector<std::int16_t> semi_global_sums(const CostVolume& volume, const SemiGlobalOptions& options) {
    std::vector<std::int16_t> sums(volume.costs.size(), 0);
    // Hirschmueller 2008, Eq. 14.
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (dx != 0 || dy != 0) add_direction(volume, options, dx, dy, sums);
    return sums;
}

}  // namespace anyrate
