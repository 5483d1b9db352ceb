#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/surface_meter.h"

namespace anyrate {

struct FitOptions {
    int rounds = 1;           ///< of measuring and moving; a batch of splits gains nothing from a second one
    double most_edges = 0.5;  ///< that a vertex moves in a round, in parts of its mean edge length
    double damping = 0.02;    ///< of the diagonal: a vertex that hardly matters stays; 0.1 is no better
};

/// Moves vertices along their normals so that the squared distance to the true surface, summed over both ways, becomes
/// least. All other vertices stay.
/// @param mesh    closed; world units
/// @param active  the vertices that may move, ascending
/// @return for every vertex of the mesh what a displacement u of it alone costs: half the second derivative of the
///         squared distance's integral, which grows by this times u squared
std::vector<double> fit_along_normals(Mesh& mesh, std::span<const std::int32_t> active, SurfaceMeter& meter,
                                      const FitOptions& options);

/// Moves vertices within their tangent planes, in two perpendicular directions one after the other, so that the same
/// distance becomes less: onto ridges and to where the surface bends, which no move along a normal can do. No face
/// shrinks or turns much; a vertex whose faces have no area stays. With fit_along_normals() in turns it is what Hoppe
/// et al. 1993, "Mesh optimization", do with all three coordinates at once.
/// @param mesh    closed; world units
/// @param active  the vertices that may move, ascending
void fit_in_tangent_planes(Mesh& mesh, std::span<const std::int32_t> active, SurfaceMeter& meter);

}  // namespace anyrate
