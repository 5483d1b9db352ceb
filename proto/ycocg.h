#pragma once
#include <algorithm>
#include <cstdint>

#include "core/types.h"

namespace anyrate {

/// A colour as luma and two chroma values, reversibly: Malvar and Sullivan, "YCoCg-R: A Color Space with RGB
/// Reversibility and Low Dynamic Range", 2003 (proto/FORMAT.md, "Colours").
struct YCoCg {
    int y = 0, co = 0, cg = 0;
};

inline YCoCg to_ycocg(const Rgb8& colour) {
    const int co = colour.r - colour.b;
    const int t = colour.b + (co >> 1);
    const int cg = colour.g - t;
    return {t + (cg >> 1), co, cg};
}

/// What leaves the range is clamped.
inline Rgb8 to_rgb(const YCoCg& c) {
    const int t = c.y - (c.cg >> 1);
    const int green = c.cg + t;
    const int blue = t - (c.co >> 1);
    const auto channel = [](int x) { return static_cast<std::uint8_t>(std::clamp(x, 0, 255)); };
    return {channel(blue + c.co), channel(green), channel(blue)};
}

}  // namespace anyrate
