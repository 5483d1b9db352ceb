#pragma once
#include "core/mesh/mesh.h"

namespace anyrate {

/// Pulls a surface straight where it passes through itself: the vertices of the faces that meet there, and their rings,
/// become a membrane over the rest (stretch()), up to four times.
/// @return whether no faces meet any more (self_intersections())
bool untangle(Mesh& mesh);

}  // namespace anyrate
