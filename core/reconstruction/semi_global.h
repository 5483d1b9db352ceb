#pragma once
#include <cstdint>
#include <vector>

#include "core/capture/image.h"

namespace anyrate {

/// What every plane of a sweep costs at every pixel: 0 (the images agree perfectly) to `worst_cost`. A pixel's planes
/// lie together: plane k of pixel (x, y) is costs[(y * width + x) * n_planes + k].
struct CostVolume {
    static constexpr std::uint8_t worst_cost = 200;  ///< of a plane that may be the surface
    static constexpr std::uint8_t impossible = 255;  ///< cost of a plane that cannot

    int width = 0, height = 0, n_planes = 0;
    std::vector<std::uint8_t> costs;

    CostVolume(int w, int h, int n);
    std::size_t first_plane(int x, int y) const {
        return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(n_planes);
    }
};

struct SemiGlobalOptions {
    int small_step = 12;  ///< price of a change by one plane from a pixel to the next, in units of the costs
    int large_step = 60;  ///< price of any larger change
};

/// Costs summed along eight paths through the image that may change plane at a price: of all planes at a pixel, the one
/// with the smallest sum fits its own images and its neighbours. Pixels outside `mask` end the paths.
/// Source: Hirschmueller 2008, "Stereo processing by semiglobal matching and mutual information", Eqs. 13 and 14.
/// @return one sum for each entry of the volume, in its order
std::vector<std::int16_t> semi_global_sums(const CostVolume& volume, const MaskImage& mask,
                                           const SemiGlobalOptions& options = {});

}  // namespace anyrate
