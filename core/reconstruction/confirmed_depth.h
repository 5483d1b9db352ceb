#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/plane_sweep.h"

namespace anyrate {

struct ConfirmOptions {
    int n_views = 2;               ///< other views that must find a surface which is contradicted
    double tolerance_px = 1.0;     ///< of disparity, within which two depths are the same
    double conflict_px = 3.0;      ///< of disparity, beyond which they contradict each other
    double max_angle_deg = 60.0;   ///< between the directions from a point to two views that are compared
    double least_agreement = 0.3;  ///< of the images, see DepthMap
};

/// What is left of depth maps, in their order.
struct ConfirmedDepths {
    std::vector<DepthMap> found;      ///< what is confirmed, and what enough other views find whoever contradicts them;
                                      ///< without the images' agreement
    std::vector<DepthMap> confirmed;  ///< what others find, and not half as many contradict
};

/// Keeps of every depth map what enough others find: the point at a pixel, carried into another view, stands at the
/// depth which that view's own map has there. It is contradicted by the views that see through the point, and those
/// that have a point of their own in front of it, on its ray. Everything else becomes unknown. Where a surface is seen
/// too badly to be matched, some views find the same false depth; then others contradict them. What nobody contradicts
/// needs one other view alone: deep in a pot no third one looks (pot, 36 views: with two others its inside ended in a
/// false floor, and Psi of 10,000 vertices was 60 instead of 18).
/// Source: Merrell et al. 2007, "Real-time visibility-based fusion of depth maps" (stability-based fusion).
ConfirmedDepths confirm_depths(std::span<const DepthMap> maps, const ConfirmOptions& options = {});

}  // namespace anyrate
