#pragma once
#include <span>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Pulls a surface straight where it passes through itself: the vertices of the faces that meet there, and their rings,
/// become a membrane over the rest (stretch()), up to four times.
/// @return whether no faces meet any more (self_intersections())
bool untangle(Mesh& mesh);

/// Takes a move of the vertices back wherever it made the surface pass through itself. A surface that did not before
/// does not afterwards.
/// @param before  the places of the vertices, as many as the mesh has
void take_tangles_back(Mesh& moved, std::span<const Vec3> before);

}  // namespace anyrate
