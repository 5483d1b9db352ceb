#include "core/reconstruction/photo_consistency.h"

namespace anyrate {

double photo_consistency(std::span<const PointColour> colours) {
    const std::size_t K = colours.size();
    if (K < 2) return 0.0;
    double F = 0.0;
    for (int k = 0; k < 3; ++k) {
        double mean = 0.0;
        for (const PointColour& colour : colours) mean += colour.c[k];
        mean /= static_cast<double>(K);
        for (const PointColour& colour : colours) F += (colour.c[k] - mean) * (colour.c[k] - mean);
    }
    // Nghiem et al., Eq. 5.
    return F / static_cast<double>(K - 1);
}

}  // namespace anyrate
