#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/surface_view.h"
#include "core/reconstruction/visibility.h"

namespace anyrate {

/// Mean edge length of a surface's mesh at a number of vertices, were they spread evenly; world units.
double vertex_spacing(const SurfaceView& surface, int n_vertices);

/// Colour of the listed vertices: the mean over the views that see the vertex, each counting by the cosine at which it
/// looks. A view gives the mean of its photograph around the vertex, about half an edge wide where edges are longer
/// than pixels: what lies between vertices cannot be shown, and would be noise. A vertex that none sees takes the mean
/// of its coloured neighbours, then theirs, grey if the whole piece is unseen.
/// @param spacing     distance between vertices that the colours are for, world units, as they stay when the mesh is
///                    refined; edges around a vertex that are shorter count instead
/// @param vertices    ascending; empty is all
/// @param visibility  of the surface by VisibilityOptions as they are, if it is at hand
/// @return one colour per listed vertex
std::vector<Rgb8> vertex_colours(const PhotoImages& images, const SurfaceView& surface, double spacing,
                                 std::span<const std::int32_t> vertices = {}, const Visibility* visibility = nullptr);

}  // namespace anyrate
