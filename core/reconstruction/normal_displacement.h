#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/silhouette_term.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// The energy of a surface as a quadratic function of normal displacements u of its active vertices, around u = 0:
/// photo-consistency (Gauss-Newton), silhouettes, and bending. World units for u.
///
///     E(u) = E(0) + g u + 1/2 u (H + damping D) u
///
/// H is never formed: it is applied triangle by triangle and ring by ring, every sum in index order.
class NormalDisplacement {
public:
    struct Weights {
        double bending =
            0.05;  ///< of a vertex's squared umbrella along its normal, in parts of the mean data curvature
        double silhouette = 30.0;  ///< of a squared pixel, per pixel of contour; squared 8-bit colour units
    };

    /// What the regularising terms weigh, and the shape at which they rest.
    struct Regularity {
        double bending = 0;                  ///< of a squared umbrella, squared colour units per squared world unit
        std::span<const double> rest;        ///< per active vertex, the umbrella along the normal that costs nothing
        std::span<const double> silhouette;  ///< per active vertex, of a squared pixel; squared colour units
    };

    /// @param active  vertices that may move, ascending
    /// @param faces   all faces around active vertices, ascending; `terms` are theirs, `silhouettes` the active
    /// vertices'
    NormalDisplacement(const SurfaceView& surface, const OneRings& rings, std::span<const Vec3> normals,
                       std::span<const std::int32_t> active, std::span<const std::int32_t> faces,
                       std::span<const TriangleTerms> terms, std::span<const SilhouetteTerm> silhouettes,
                       const Regularity& regularity);

    /// The displacement of every active vertex that minimises the damped quadratic, by conjugate gradients.
    /// @param damping of the diagonal, 0 the Gauss-Newton step
    std::vector<double> solve(double damping) const;

private:
    std::vector<double> apply(std::span<const double> u, double damping) const;

    struct Umbrella {                                               ///< n_v . (mean of the ring - x_v), linear in u
        std::vector<std::pair<std::int32_t, double>> coefficients;  ///< active index, derivative
        double value = 0;                                           ///< at u = 0, less the rest value
    };
    std::size_t n_;
    double bending_weight_;
    std::vector<std::array<std::int32_t, 3>> face_active_;  ///< active index of each corner, -1 for a fixed one
    std::vector<std::array<double, 6>> face_hessian_;
    std::vector<std::vector<std::pair<std::int32_t, std::int32_t>>> vertex_faces_;  ///< per active: (face slot, corner)
    std::vector<Umbrella> umbrellas_;                                               ///< per active
    std::vector<std::vector<std::pair<std::int32_t, double>>> vertex_umbrellas_;    ///< transpose
    std::vector<double> gradient_, own_hessian_, diagonal_;
};

/// Umbrella along the normal, n_v . (mean of the ring - x_v), of each listed vertex, world units.
std::vector<double> umbrellas(const SurfaceView& surface, const OneRings& rings, std::span<const Vec3> normals,
                              std::span<const std::int32_t> vertices);

}  // namespace anyrate
