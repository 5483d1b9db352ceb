#pragma once
#include <cstdint>
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
    std::vector<Vec3> face_normals;             ///< unit, one per triangle; zero for one without area
    std::vector<Vec3> samples;                  ///< uniform by area, and so is every first part of them
    std::vector<std::int32_t> sample_faces;     ///< the triangle that a sample lies on
    std::vector<std::int32_t> samples_in_tour;  ///< all of them, those near each other mostly following each other
    double area = 0;
};

}  // namespace anyrate
