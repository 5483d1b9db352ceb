#include "core/progressive/base_on_grid.h"

#include <algorithm>
#include <cmath>

namespace anyrate {
namespace {

constexpr double grid_margin = 0.04;  ///< of the largest extent, kept free on each side

}  // namespace

Grid make_grid(const Mesh& mesh, int n_vertices) {
    Vec3 lower = mesh.vertices.front(), upper = lower;
    for (const Vec3& v : mesh.vertices) {
        lower = lower.cwiseMin(v);
        upper = upper.cwiseMax(v);
    }
    const double extent = (upper - lower).maxCoeff();
    Grid grid;
    grid.bits = n_vertices > 50'000 ? 16 : 14;
    grid.base_shift = grid.bits - 12;
    grid.unit = extent * (1 + 2 * grid_margin) / (std::ldexp(1.0, grid.bits) - 1);
    grid.origin = lower - Vec3::Constant(grid_margin * extent);
    return grid;
}

BaseMesh to_base(const Mesh& mesh, const Grid& grid) {
    BaseMesh base;
    base.triangles = mesh.triangles;
    base.positions.reserve(mesh.vertices.size());
    const double cell = std::ldexp(1.0, grid.base_shift);
    const auto largest = static_cast<std::int32_t>((1 << (grid.bits - grid.base_shift)) - 1);
    for (const Vec3& v : mesh.vertices) {
        const Vec3 p = (v - grid.origin) / (grid.unit * cell);
        const auto snap = [&](double x) {
            return std::clamp(static_cast<std::int32_t>(std::lround(x)), 0, largest) << grid.base_shift;
        };
        base.positions.push_back({snap(p.x()), snap(p.y()), snap(p.z())});
    }
    return base;
}

}  // namespace anyrate
