#pragma once
// The rules of the operation that a log may choose: values and formulas are those of proto/FORMAT.md.
#include <cstdint>

namespace anyrate {

/// Which edges opposite to a new vertex give way to the other diagonal (FORMAT.md, "Flip").
enum class FlipRule : std::uint8_t {
    delaunay = 1,           ///< those whose opposite angles sum to more than 180 degrees: nearly equilateral everywhere
    crease_preserving = 2,  ///< of these, only those between nearly coplanar faces, or between needles
    curvature_aligned =
        3,  ///< the same, with angles in the metric of the surface's curvature: long where it is straight
};

/// How far the six vertices around a split face are smoothed along the surface (FORMAT.md, "Update the six").
enum class RingSmoothing : std::uint8_t { quarter = 1, sixteenth = 2 };

/// The rules a header fixes for a whole log.
struct RefinementRules {
    int step_ratio = 80;  ///< a step is the power of two of grid units nearest to edge / step_ratio
    FlipRule flip_rule = FlipRule::curvature_aligned;
    RingSmoothing ring_smoothing = RingSmoothing::sixteenth;
    friend bool operator==(const RefinementRules&, const RefinementRules&) = default;
};

}  // namespace anyrate
