#pragma once
#include "core/mesh/mesh.h"
#include "core/mesh/surface_meter.h"

namespace anyrate {

/// A coarse mesh such as a log starts from: a surface simplified by quadrics, moved to where its squared distance to
/// the surface is least.
/// @param mesh      closed and manifold
/// @param meter     of the same surface
/// @param may_meet  whether faces may come to meet elsewhere than in what they share, as the surface's own do
/// @throws InputError if so few vertices cannot carry the surface
Mesh fit_coarse_mesh(const Mesh& mesh, int n_vertices, SurfaceMeter& meter, bool may_meet = false);

/// The longest part of it, on one thread: the surface as it is simplified first. For who has other work meanwhile.
Mesh first_coarse_stage(const Mesh& mesh, int n_vertices, bool may_meet = false);

/// The rest of it.
/// @param stage  first_coarse_stage() of the mesh
Mesh fit_coarse_mesh(const Mesh& mesh, Mesh stage, int n_vertices, SurfaceMeter& meter, bool may_meet = false);

}  // namespace anyrate
