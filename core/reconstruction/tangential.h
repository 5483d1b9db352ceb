#pragma once
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// Tangential Laplacian L - <L, N> N with L = mean of the ring - p (Nghiem et al., Eq. 12): evens out the mesh without
/// moving the surface. @return world units
Vec3 tangential_laplacian(const SurfaceView& surface, const OneRings& rings, const Vec3& normal, std::int32_t vertex);

}  // namespace anyrate
