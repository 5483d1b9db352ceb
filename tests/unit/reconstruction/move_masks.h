#pragma once
#include <cstdint>

#include "core/capture/capture.h"
#include "core/reconstruction/silhouette_term.h"

namespace anyrate {

/// Moves the borders of all masks outwards, pixels; inwards if negative.
inline void move_masks(Capture& capture, double px) {
    for (View& view : capture.views) {
        const Image<std::int8_t> distance = silhouette_distance(view.mask);
        for (std::size_t p = 0; p < distance.pixels.size(); ++p)
            view.mask.pixels[p] = distance.pixels[p] > -8 * px ? 255 : 0;
    }
}

}  // namespace anyrate
