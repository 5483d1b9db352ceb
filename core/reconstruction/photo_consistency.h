#pragma once
#include <span>

namespace anyrate {

/// The colour of one surface point in one of the views that see it, 8-bit units.
struct PointColour {
    float c[3];
};

/// Photo-consistency F(p): the unbiased variance of the point's colour over the K views that see it, summed over the
/// channels. Source: Nghiem et al., Eq. 5, in the two-pass form (the one-pass form of the paper cancels in single
/// precision).
/// @return squared 8-bit colour units; 0 for fewer than two views, which give no evidence
double photo_consistency(std::span<const PointColour> colours);

}  // namespace anyrate
