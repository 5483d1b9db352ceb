#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// By how much every view shows a surface beside where its camera puts it, pixels of the photographs: a camera that is
/// turned a little wrongly moves its whole image. For each view in turn the shift at which its colours fit the mean of
/// what the others show of the same points, by Gauss-Newton steps with robust weights; the surface is taken as it is.
/// A view that shares too little with others has the shift 0.
/// Source: Lucas and Kanade 1981, "An iterative image registration technique", with the surface to carry the template.
/// @param level  of the pyramid, where colours are compared
/// @return one shift a view
std::vector<Vec2> estimate_shifts(const PhotoImages& images, const SurfaceView& surface, int level);

/// Splits shifts into a translation of the surface and what is left of them, which is the least possible (sum of
/// squares): a surface that has moved by the translation fits images shifted by the rest as well as it did before.
/// Images cannot tell these apart; cameras that are off independently of each other are off least together. A view
/// without a shift has none afterwards.
/// @param point  in the middle of the surface
/// @param shifts  pixels of the photographs, one entry a view; the rest afterwards
/// @return the translation
Vec3 take_translation(const PhotoImages& images, const Vec3& point, std::span<Vec2> shifts);

/// Moves what every camera shows, at all levels, by its shift, pixels of the photographs; one entry a view.
void shift_views(PhotoImages& images, std::span<const Vec2> shifts);

}  // namespace anyrate
