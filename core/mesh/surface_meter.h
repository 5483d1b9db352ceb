#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/true_surface.h"

namespace anyrate {

/// How far a face is from the true surface, both ways with half the weight each: points of the face to the surface, and
/// points of the surface whose nearest face it is. With u the displacements of its corners along their normals, world
/// units, the integral over the squared distances to the tangent planes is
///
///     E(u) = E(0) + g u + 1/2 u H u
struct FaceDistance {
    double area = 0;     ///< that was measured, world units squared
    double squared = 0;  ///< integral of the squared distance, world units to the fourth
    std::array<double, 3> gradient{};
    std::array<double, 6> hessian{};  ///< 00 11 22 01 12 20
};

/// Measures meshes that change little from one to the next. Remembers where the last search ended, which saves time and
/// changes nothing but which of several equally near points is found.
class SurfaceMeter {
public:
    /// @param surface        must outlive it
    /// @param fewest_points  of a mesh of few faces: their shape has to be seen, too
    explicit SurfaceMeter(const TrueSurface& surface, int fewest_points = 60'000)
        : surface_(surface), fewest_points_(fewest_points) {}

    /// @param normals  unit, one per vertex of the mesh: the directions in which the vertices may move
    /// @return one per face
    std::vector<FaceDistance> measure(const Mesh& mesh, std::span<const Vec3> normals);

private:
    /// The nearest point of the mesh on the same side, for each of the first samples.
    std::vector<Vec3> nearest_to_samples(const Mesh& mesh, std::size_t n_samples);

    const TrueSurface& surface_;
    int fewest_points_;
    std::vector<std::int32_t> nearest_of_face_;    ///< the true face last found from each face; -1: none yet
    std::vector<std::int32_t> nearest_of_sample_;  ///< the face last found from each true sample
};

}  // namespace anyrate
