#pragma once
#include "core/encoding/surface_meter.h"
#include "core/mesh/mesh.h"

namespace anyrate {

/// The coarse mesh that a log starts from: the true surface simplified by quadrics, moved to where its squared distance
/// to the true surface is least.
/// @param mesh  closed and manifold
/// @throws InputError if so few vertices cannot carry the surface
Mesh fit_base(const Mesh& mesh, int n_vertices, SurfaceMeter& meter);

}  // namespace anyrate
