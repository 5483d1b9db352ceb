#pragma once
#include <span>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Bends the flagged parts of a surface as little as the rest allows: minimises the squared umbrella (mean of the ring
/// less the vertex) over the flagged vertices and their neighbours, plus attachment times the squared way from where
/// each flagged vertex was. Small holes in what is known are closed by the curvature around them, bumps of up to about
/// pi attachment^(-1/4) edges go, and what is wider keeps its shape.
/// Source: Botsch and Kobbelt 2004, "An intuitive framework for real-time freeform modeling", Sect. 3, with uniform
/// weights.
/// @param movable     one flag a vertex
/// @param attachment  without unit, above 0
void fair(Mesh& mesh, std::span<const char> movable, double attachment);

/// Stretches the flagged parts of a surface over the rest like a membrane: each flagged vertex becomes the mean of its
/// ring. Within a flat rim the result is flat; a part without a rim hardly moves.
/// @param movable  one flag a vertex
void stretch(Mesh& mesh, std::span<const char> movable);

}  // namespace anyrate
