#pragma once
// What a capture may suffer in practice, one function each, so that a benchmark can tell what it costs.
#include <cstdint>

#include "core/capture/capture.h"
#include "core/mesh/mesh.h"

namespace anyrate::bench {

/// Another unit and origin of the world: every point p becomes scale p + origin, and the images stay as they are.
void move_world(Capture& capture, double scale, const Vec3& origin);
void move_world(Mesh& mesh, double scale, const Vec3& origin);

/// Every `step`-th view, the first among them, is resampled to `factor` of its width and height.
void resample(Capture& capture, double factor, std::size_t step = 1);

/// Every view's colours are multiplied by a number of its own, from 1 - range to 1 + range.
void change_gain(Capture& capture, double range, std::uint64_t seed);

/// Masks grow by a disc of this radius, or shrink if it is negative.
void grow_masks(Capture& capture, int radius_px);

/// Every camera turns about its centre so that what it sees moves by `distance_px` in a random direction, its image
/// staying what it is.
void disturb_poses(Capture& capture, double distance_px, std::uint64_t seed);

/// Keeps the views 0, n, 2 n, ...
void keep_every(Capture& capture, int n);

/// Every view is cut to a window of `part` of its width and height, at a random place; the pixels stay as they are.
void crop(Capture& capture, double part, std::uint64_t seed);

/// The photographs as if the surface's texture were faded to a part of its contrast: blended with those of plain clay
/// under the simulation's light, the sensor's noise staying what it is.
/// @param kept  of the texture, from 0 (plain clay) to 1 (the photographs as they are)
void fade_texture(Capture& capture, const Mesh& surface, double kept, std::uint64_t seed);

}  // namespace anyrate::bench
