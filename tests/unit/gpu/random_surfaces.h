#pragma once
// Surfaces that CPU and GPU are compared on.
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/simulation/parametric_meshes.h"

namespace anyrate {

struct RandomSurface {
    std::string name;  ///< with the seed, for messages
    Mesh mesh;
};

/// Spheres and tori near the unit sphere, every vertex moved at random: parts hide each other, faces are small, large,
/// steep.
inline std::vector<RandomSurface> random_surfaces() {
    std::vector<RandomSurface> surfaces;
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> offset(-0.03, 0.03);
        Mesh sphere = icosphere(2 + static_cast<int>(seed) % 2, 0.97), ring = torus(0.65, 0.3, 30, 20);
        for (Mesh* mesh : {&sphere, &ring})
            for (Vec3& v : mesh->vertices) v += Vec3(offset(random), offset(random), offset(random));
        surfaces.push_back({"sphere, seed " + std::to_string(seed), std::move(sphere)});
        surfaces.push_back({"torus, seed " + std::to_string(seed), std::move(ring)});
    }
    return surfaces;
}

}  // namespace anyrate
