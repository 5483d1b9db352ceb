#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// Colour of the listed vertices: the mean over the views that see the vertex, each counting by the cosine at which it
/// looks. A vertex that none sees takes the mean of its coloured neighbours, then theirs, grey if the whole piece is
/// unseen.
/// @param vertices ascending; empty is all. @return one colour per listed vertex
std::vector<Rgb8> vertex_colours(const PhotoImages& images, const SurfaceView& surface,
                                 std::span<const std::int32_t> vertices = {});

}  // namespace anyrate
