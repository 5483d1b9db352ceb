#include "core/reconstruction/mask_growth.h"

#include <algorithm>

namespace anyrate {
namespace {

constexpr std::size_t fewest_contours = 100;  ///< rim vertices, over all views
/// What a mesh's contours lie inside borders that are right, pixels: its rim vertices are not quite where the surface
/// turns away, and its edges are chords (nefertiti, bowl, pot: 0.1 to 0.3).
constexpr double usual_px = 0.2;

}  // namespace

double estimate_mask_growth(Silhouettes& silhouettes, const SurfaceView& surface, double reach_px) {
    const OneRings rings(surface);
    silhouettes.look(surface);
    std::vector<double> distances =
        silhouettes.contour_distances(surface, rings, vertex_normals(surface, rings), reach_px);
    if (distances.size() < fewest_contours) return 0;
    const auto median = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), median, distances.end());
    return usual_px - *median;
}

}  // namespace anyrate
