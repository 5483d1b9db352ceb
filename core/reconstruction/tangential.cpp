#include "core/reconstruction/tangential.h"

namespace anyrate {

Vec3 tangential_laplacian(const SurfaceView& surface, const OneRings& rings, const Vec3& normal, std::int32_t vertex) {
    const auto ring = rings.neighbours(vertex);
    Vec3 mean = Vec3::Zero();
    for (std::int32_t w : ring) mean += surface.vertices[static_cast<std::size_t>(w)];
    // Nghiem et al., Eq. 12.
    const Vec3 L = mean / static_cast<double>(ring.size()) - surface.vertices[static_cast<std::size_t>(vertex)];
    return L - L.dot(normal) * normal;
}

}  // namespace anyrate
