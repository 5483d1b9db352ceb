#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/plane_sweep.h"

namespace anyrate {

struct ConfirmOptions {
    int n_views = 2;               ///< other views that must find the same surface
    double tolerance_px = 1.0;     ///< of disparity, within which two depths are the same
    double least_agreement = 0.3;  ///< of the images, see DepthMap
};

/// Keeps of every depth map what enough others confirm: the point at a pixel, carried into another view, stands at the
/// depth which that view's own map has there. Everything else becomes unknown.
std::vector<DepthMap> confirm_depths(std::span<const DepthMap> maps, const ConfirmOptions& options = {});

}  // namespace anyrate
