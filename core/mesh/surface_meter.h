#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/true_surface.h"

namespace anyrate {

/// A symmetric 3x3 matrix: 00 11 22 01 12 20.
using Symmetric3 = std::array<double, 6>;

/// How far a face is from the true surface, both ways with half the weight each: points of the face to the surface, and
/// points of the surface whose nearest face it is.
struct FaceDistance {
    double area = 0;     ///< that was measured, world units squared
    double squared = 0;  ///< integral of the squared distance, world units to the fourth
};

/// How that distance changes as the corners of the face move. With u_k their displacements, world units, the integral
/// over the squared distances to the tangent planes is
///
///     E(u) = E(0) + sum_k g_k . u_k + 1/2 sum_kl u_k . H_kl u_l
struct FaceQuadratic {
    std::array<Vec3, 3> gradient{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  ///< g_k
    std::array<Symmetric3, 6> hessian{};                                     ///< H_kl of corners 00 11 22 01 12 20
};

/// Measures meshes that change little from one to the next. Remembers where the last search ended, which saves time and
/// changes nothing but which of several equally near points is found.
class SurfaceMeter {
public:
    /// @param surface        must outlive it
    /// @param fewest_points  of a mesh of few faces: their shape has to be seen, too
    explicit SurfaceMeter(const TrueSurface& surface, int fewest_points = 60'000)
        : surface_(surface), fewest_points_(fewest_points) {}

    /// @param mesh  world units
    /// @return one per face
    std::vector<FaceDistance> distances(const Mesh& mesh);
    /// @param mesh  world units
    /// @return one per face
    std::vector<FaceQuadratic> quadratics(const Mesh& mesh);

private:
    /// Adds to one Face each what the pairs of points that should meet say of it.
    template <class Face>
    std::vector<Face> measure(const Mesh& mesh);
    /// The nearest point of the mesh on the same side, for each of the first samples.
    std::vector<Vec3> nearest_to_samples(const Mesh& mesh, std::size_t n_samples);

    const TrueSurface& surface_;
    int fewest_points_;
    std::vector<std::int32_t> nearest_of_face_;    ///< the true face last found from each face; -1: none yet
    std::vector<std::int32_t> nearest_of_sample_;  ///< the face last found from each true sample
};

}  // namespace anyrate
