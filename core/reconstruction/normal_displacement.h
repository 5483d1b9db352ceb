#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/silhouette_term.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

constexpr int max_cg_iterations = 60;
constexpr double cg_tolerance = 1e-3;  ///< of the residual's norm: the step is damped and clamped anyway

/// The energy of a surface as a quadratic function of normal displacements u of its active vertices, around u = 0:
/// photo-consistency (Gauss-Newton), silhouettes, and bending. World units for u.
///
///     E(u) = E(0) + g u + 1/2 u (H + damping D) u
///
/// A vertex's row of H but for bending holds itself and its ring; bending, which reaches two rings far, is the product
/// of two such rows. Every sum is taken in index order.
class NormalDisplacement {
public:
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
    /// The quadratic's matrix times u.
    /// @param bent  n_ values, for what umbrellas u makes
    void apply(std::span<const double> u, double damping, std::span<double> bent, std::span<double> out) const;

    /// What the displacement of `vertex` does to the row's own vertex, and the other way round.
    struct Entry {
        std::int32_t vertex = 0;             ///< active index
        double hessian = 0;                  ///< of photo-consistency and silhouettes
        double umbrella = 0, transpose = 0;  ///< derivative of the row's umbrella by it, of its umbrella by the row's
    };
    std::span<const Entry> row(std::size_t i) const { return {entries_.data() + begin_[i], begin_[i + 1] - begin_[i]}; }

    std::size_t n_;
    double bending_weight_;
    std::vector<std::size_t> begin_;  ///< of each active vertex's row
    std::vector<Entry> entries_;      ///< a row's own vertex first
    std::vector<double> gradient_, diagonal_;
};

/// Umbrella along the normal, n_v . (mean of the ring - x_v), of each listed vertex, world units.
std::vector<double> umbrellas(const SurfaceView& surface, const OneRings& rings, std::span<const Vec3> normals,
                              std::span<const std::int32_t> vertices);

/// The mean of a vertex's value and those of its neighbours that are listed, too.
/// @param values      one per listed vertex, any unit
/// @param vertices    ascending
/// @param n_vertices  of the surface
/// @return one per listed vertex
std::vector<double> ring_means(std::span<const double> values, const OneRings& rings,
                               std::span<const std::int32_t> vertices, std::size_t n_vertices);

}  // namespace anyrate
