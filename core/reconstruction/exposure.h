#pragma once
#include <array>
#include <span>
#include <vector>

#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// What a view's red, green and blue are multiplied by, against the mean view.
using Gains = std::array<double, 3>;

/// How much brighter or darker each view is than the others, from what several views show of the same surface: the
/// gains and the colours of the points that explain the logarithms of what was photographed best, by alternation, with
/// medians over a view so that highlights and hidden points do not count. The surface may be as rough as step 1 leaves
/// it. A view that shares nothing with others has the gain 1; the gains of a channel have the geometric mean 1.
/// Source: Brown and Lowe 2007, "Automatic panoramic image stitching using invariant features", Sect. 6, on a surface.
std::vector<Gains> estimate_gains(const PhotoImages& images, const SurfaceView& surface);

/// Divides the views' colours by their gains if one of these is off by more than the estimate may be, 2 %; what exceeds
/// 255 is cut off. Evenly exposed views stay as they are, bit for bit.
/// @return the gains they were divided by, one a view; empty if they stay as they are
std::vector<Gains> even_out_exposure(PhotoImages& images, const SurfaceView& surface);

/// Divides the views' colours by gains, one a view.
void divide_by_gains(PhotoImages& images, std::span<const Gains> gains);

}  // namespace anyrate
