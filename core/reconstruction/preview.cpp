#include "core/reconstruction/preview.h"

#include <algorithm>

#include "core/mesh/decimate.h"
#include "core/mesh/topology.h"
#include "core/reconstruction/iso_surface.h"
#include "core/reconstruction/poisson.h"

namespace anyrate {
namespace {

constexpr double cells_of_extent = 40;  ///< of the grid along the object's largest extent
constexpr int n_vertices = 1500;        ///< 3 to 4 KB of base

}  // namespace

Mesh preview_mesh(const VisualHull& hull) {
    const double spacing = std::max(hull.cell, (hull.upper - hull.lower).maxCoeff() / cells_of_extent);
    const Mesh surface = largest_component(iso_surface(poisson_field(hull.points, {.spacing = spacing})));
    return surface.n_vertices() > n_vertices ? decimate(surface, n_vertices) : surface;
}

}  // namespace anyrate
