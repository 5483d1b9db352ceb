#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/capture/image.h"

namespace anyrate {

/// What the planes of a sweep cost at every pixel: 0 (the images agree perfectly) to `worst_cost`. A pixel has the
/// planes of a range of its own, which lie together.
struct CostVolume {
    static constexpr std::uint8_t worst_cost = 200;  ///< of a plane that may be the surface
    static constexpr std::uint8_t impossible = 255;  ///< of what fills a range up to whole lanes
    static constexpr int lanes = 8;                  ///< ranges are stored as multiples of so many planes

    /// The planes of one pixel: `n` of them, from `first`; the first one's cost is costs[start].
    struct Range {
        std::int32_t first = 0, n = 0;
        std::size_t start = 0;
    };

    int width = 0, height = 0, n_planes = 0;
    std::vector<Range> ranges;  ///< row by row
    std::vector<std::uint8_t> costs;

    /// All planes cost worst_cost.
    /// @param first, last  planes of each pixel, last one included, 0 .. n - 1; none where first > last
    CostVolume(int n, const Image<std::int16_t>& first, const Image<std::int16_t>& last);

    const Range& at(int x, int y) const {
        return ranges[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
};

struct SemiGlobalOptions {
    int small_step = 12;  ///< price of a change by one plane from a pixel to the next, in units of the costs
    int large_step = 60;  ///< price of any larger change
};

/// Costs summed along eight paths through the image that may change plane at a price: of all planes at a pixel, the one
/// with the smallest sum fits its own images and its neighbours. Pixels without planes end the paths.
/// Source: Hirschmueller 2008, "Stereo processing by semiglobal matching and mutual information", Eqs. 13 and 14.
/// @return one sum for each entry of the volume's costs, in their order
std::vector<std::int16_t> semi_global_sums(const CostVolume& volume, const SemiGlobalOptions& options = {});

}  // namespace anyrate
