#pragma once
#include <string>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Refuses what is no closed manifold surface of one piece with finite coordinates.
/// @param name  of the mesh, for the sentence
/// @throws InputError saying what was found and what was expected
void require_closed_surface(const Mesh& mesh, const std::string& name);

}  // namespace anyrate
