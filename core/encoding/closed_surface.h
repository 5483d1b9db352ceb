#pragma once
#include "core/mesh/mesh.h"

namespace anyrate {

/// Refuses what is no closed manifold surface of one piece with finite coordinates.
/// @throws InputError saying what was found and what was expected
void require_closed_surface(const Mesh& mesh);

}  // namespace anyrate
