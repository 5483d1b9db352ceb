#pragma once
// Meshes as bases of refinable meshes.
#include <cmath>

#include "core/mesh/mesh.h"
#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// Holds the unit sphere around the origin.
inline const Grid unit_grid{Vec3(-1.2, -1.2, -1.2), 2.4 / 16383, 14, 2};

/// Every vertex at the nearest position that a base may have.
inline BaseMesh on_grid(const Mesh& mesh, const Grid& grid) {
    const int cell = 1 << grid.base_shift;
    BaseMesh base;
    base.triangles = mesh.triangles;
    for (const Vec3& v : mesh.vertices) {
        const Vec3 p = (v - grid.origin) / (grid.unit * cell);
        const auto snapped = [&](double x) { return cell * static_cast<std::int32_t>(std::lround(x)); };
        base.positions.push_back({snapped(p.x()), snapped(p.y()), snapped(p.z())});
    }
    return base;
}

}  // namespace anyrate
