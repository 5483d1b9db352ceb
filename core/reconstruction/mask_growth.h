#pragma once
#include "core/reconstruction/silhouette_term.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// By how much all masks together are too small, pixels of the photographs, negative if too large: how far outside
/// their borders the contours of a surface lie that follows the colours as well. Segmentations err alike in all views;
/// their silhouettes would pull the contours of a surface in or out by as much.
/// @param silhouettes  whose borders are taken as they were moved; looks at the surface
/// @param reach_px     see Silhouettes::terms()
/// @return 0 if there are too few contours to tell
double estimate_mask_growth(Silhouettes& silhouettes, const SurfaceView& surface, double reach_px);

}  // namespace anyrate
