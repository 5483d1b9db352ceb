#pragma once
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// Mean curvature normal H n of every vertex, pointing to where the surface would shrink (inward on a sphere, of length
/// 1/R), 1 / world units; cotangent weights over the mixed area. Source: Meyer, Desbrun, Schroeder, Barr 2003.
std::vector<Vec3> mean_curvature_normals(const SurfaceView& surface, const OneRings& rings);

}  // namespace anyrate
