#pragma once
#include <algorithm>

namespace anyrate {

/// The pixels from (x0, y0) to just before (x1, y1).
struct PixelBox {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }
    bool is_empty() const { return x0 >= x1 || y0 >= y1; }
    bool holds(const PixelBox& other) const {
        return x0 <= other.x0 && y0 <= other.y0 && x1 >= other.x1 && y1 >= other.y1;
    }
    /// Makes it hold a pixel, too.
    void extend(int x, int y) {
        if (is_empty()) *this = {x, y, x + 1, y + 1};
        *this = {std::min(x0, x), std::min(y0, y), std::max(x1, x + 1), std::max(y1, y + 1)};
    }
};

}  // namespace anyrate
