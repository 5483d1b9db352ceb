#pragma once
// Lengths on a surface as the error of a triangle counts them: proto/FORMAT.md, "Metric".
#include <array>
#include <optional>

#include "core/progressive/lattice_arithmetic.h"

namespace anyrate {

/// A metric of a face's plane in which a length counts for more the more the surface bends along it: the absolute value
/// of the curvature tensor, and a part of its mean in all directions, so that no direction counts for nothing.
/// Of two diagonals the one that is Delaunay's in it approximates the surface best (D'Azevedo and Simpson 1989, "On
/// optimal interpolation triangle incidences").
struct CurvatureMetric {
    LatticeVector u, v;             ///< orthonormal, of the plane
    double xx = 0, xy = 0, yy = 0;  ///< the symmetric tensor in that basis, grid units of height for squared ones

    double inner_product(const LatticeVector& a, const LatticeVector& b) const {
        const double ax = dot(a, u), ay = dot(a, v), bx = dot(b, u), by = dot(b, v);
        return (xx * (ax * bx) + xy * (ax * by + ay * bx)) + yy * (ay * by);
    }
};

/// The metric of a face by its corners and their unit normals, which fix the curvature tensor along its three edges
/// (Rusinkiewicz 2004, "Estimating curvatures and their derivatives on triangle meshes").
/// @param corners  grid units
/// @return nullopt if the face has no area or the surface does not bend
inline std::optional<CurvatureMetric> curvature_metric(const std::array<LatticeVector, 3>& corners,
                                                       const std::array<LatticeVector, 3>& normals) {
    constexpr double all_directions = 0.3125;  // part of the mean; with 0.1 a bust is 2 % worse, 0.6 does as well
    const LatticeVector first = corners[1] - corners[0], third = corners[2] - corners[0];
    const LatticeVector area_vector = cross(first, third);
    const double area = length(area_vector), base = length(first);
    if (!(area > 0)) return std::nullopt;
    const LatticeVector u = first / base, v = cross(area_vector / area, u);

    // Curvature along an edge times its squared length: how far its ends' normals turn.
    const auto bend = [&](std::size_t i, std::size_t j) {
        const LatticeVector edge = corners[j] - corners[i];
        return dot(edge, normals[i]) - dot(edge, normals[j]);
    };
    // a xx + 2 b xy + c yy, at the edges (base, 0), (x - base, y) and (-x, -y).
    const double bend_0 = bend(0, 1), bend_1 = bend(1, 2), bend_2 = bend(2, 0);
    const double x = dot(third, u), y = area / base;
    const double a = bend_0 / (base * base);
    const double b = ((bend_2 - bend_1) - a * (base * (2 * x - base))) / (2 * (base * y));
    const double c = ((bend_2 - a * (x * x)) - 2 * (b * (x * y))) / (y * y);

    // The square root of the tensor's square, in closed form.
    const double determinant = a * c - b * b, size = determinant < 0 ? -determinant : determinant;
    const double root = std::sqrt(((a * a + c * c) + 2 * (b * b)) + 2 * size);
    if (!(root > 0)) return std::nullopt;
    const double xx = ((a * a + b * b) + size) / root, yy = ((b * b + c * c) + size) / root;
    const double more = all_directions * ((xx + yy) * 0.5);
    return CurvatureMetric{.u = u, .v = v, .xx = xx + more, .xy = (b * (a + c)) / root, .yy = yy + more};
}

}  // namespace anyrate
