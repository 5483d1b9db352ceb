#pragma once
#include "core/capture/capture.h"

namespace anyrate {

/// Radial and tangential lens distortion, in OpenCV's order and meaning. A point (x, y) of the plane at depth 1 is seen
/// at
///   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
///   y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y,   r^2 = x^2 + y^2.
/// Source: D. C. Brown, Close-range camera calibration, 1971, Eqs. 5 and 6, as in the OpenCV manual.
struct Distortion {
    double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0;

    bool is_none() const { return k1 == 0.0 && k2 == 0.0 && p1 == 0.0 && p2 == 0.0 && k3 == 0.0; }
    /// Where the point is seen, both in the plane at depth 1.
    Vec2 distort(const Vec2& point) const;
};

/// Resamples image and mask as an ideal lens with the same K would have taken them, bilinearly; a mask pixel is object
/// if at least half of it is. What the photograph does not show becomes black background, and so does what lies beyond
/// the radius at which the polynomial turns back (there it describes no lens).
void undistort(View& view, const Distortion& lens);

}  // namespace anyrate
