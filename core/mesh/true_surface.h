#pragma once
#include <vector>

#include "core/mesh/nearest_surface.h"

namespace anyrate {

/// The surface that a log is to approach, prepared for questions.
struct TrueSurface {
    /// @param mesh       with an area
    /// @param n_samples  how many points of it stand for the whole
    /// @throws InputError if `mesh` has no area
    TrueSurface(const Mesh& mesh, int n_samples);

    NearestSurface nearest;
    std::vector<Vec3> face_normals;    ///< unit, one per triangle; zero for one without area
    std::vector<Vec3> samples;         ///< uniform by area, and so is every first part of them
    std::vector<Vec3> sample_normals;  ///< unit, of the triangle that a sample lies on
    double area = 0;
};

}  // namespace anyrate
