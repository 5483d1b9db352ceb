#pragma once
#include "core/capture/capture.h"
#include "core/mesh/mesh.h"

namespace anyrate::bench {

/// Intersection over union of a view's mask and the surface's silhouette, a pixel belonging to it if at least half of
/// it is covered. 0 where both are empty.
/// @param surface  closed, in front of the camera
double silhouette_overlap(const Mesh& surface, const View& view);

}  // namespace anyrate::bench
