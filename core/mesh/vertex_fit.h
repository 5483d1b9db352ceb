#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/surface_meter.h"

namespace anyrate {

struct FitOptions {
    bool slides = false;      ///< vertices also move within their tangent planes
    double most_edges = 0.5;  ///< that a vertex moves along its normal, in parts of its mean edge length
    double damping = 0.02;    ///< of the diagonal: a vertex that hardly matters stays; 0.1 is no better
};

/// Moves vertices to where the squared distance to the true surface, summed over both ways, is least for the pairs of
/// points that one measurement finds: along their normals, and before that, if they slide, in two perpendicular
/// directions of their tangent planes, one after the other, onto ridges and to where the surface bends, which no move
/// along a normal can do. No face turns over, nor does a slide shrink or turn one much; a vertex whose faces have no
/// area does not slide. All other vertices stay. Measuring once for all three coordinates, as Hoppe et al. 1993, "Mesh
/// optimization", do, takes a third of the time of measuring before each, and the base of a reconstruction is as near.
/// @param mesh    closed; world units
/// @param active  the vertices that may move, ascending
/// @return for every vertex of the mesh what a displacement u of it alone along its normal costs: half the second
///         derivative of the squared distance's integral, which grows by this times u squared
std::vector<double> fit_vertices(Mesh& mesh, std::span<const std::int32_t> active, SurfaceMeter& meter,
                                 const FitOptions& options);

}  // namespace anyrate
