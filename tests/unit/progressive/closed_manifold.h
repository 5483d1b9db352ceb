#pragma once
#include <string>

#include "core/progressive/refinable_mesh.h"

namespace anyrate::testing {

/// What is wrong with a mesh as a closed, consistently oriented manifold on its grid, judged from its triangles alone,
/// and then whether its twins and valences agree; empty if nothing is.
std::string fault_of(const RefinableMesh& mesh);

/// V - E + F, from the triangles.
int euler_characteristic(const RefinableMesh& mesh);

/// Whether two states are the same in everything that decoding depends on and that can be seen.
bool same_state(const RefinableMesh& a, const RefinableMesh& b);

}  // namespace anyrate::testing
