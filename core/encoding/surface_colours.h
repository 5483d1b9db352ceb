#pragma once
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/nearest_surface.h"

namespace anyrate {

/// Colour of the nearest point of a surface, for each of some points; the corners' colours are interpolated.
/// @param mesh     without colours: the result is empty
/// @param nearest  of the same mesh
std::vector<Rgb8> surface_colours(const Mesh& mesh, const NearestSurface& nearest, std::span<const Vec3> points);

}  // namespace anyrate
