#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "core/capture/capture.h"
#include "core/mesh/mesh.h"

namespace anyrate {

/// Linear-light RGB in [0, 1] that a surface point sends in every direction, from its position and unit normal.
using Appearance = std::function<Vec3(const Vec3& point, const Vec3& normal)>;

/// A textured surface, ready to be seen.
struct Model {
    Mesh surface;               ///< closed, wound counter-clockwise seen from outside
    std::vector<Vec3> normals;  ///< unit, one per vertex
    Appearance appearance;
};

/// The share of a fixed, soft light that arrives at a surface with this unit normal, in [0, 1]: a function of the
/// normal alone (no shadows, no highlights), hence the same from every view.
double studio_light(const Vec3& normal);

struct RenderOptions {
    int supersampling = 3;   ///< samples a pixel, per axis
    double noise = 1.0;      ///< standard deviation, 8-bit levels
    std::uint64_t seed = 1;  ///< of the noise; give every view its own
};

/// What a camera sees of the model in front of a dark background: the mean linear light over a pixel, then gamma 2.2
/// and sensor noise. The mask is 255 where at least half of a pixel's samples hit the surface.
View render_view(const Model& model, const Camera& camera, std::string name, const RenderOptions& options);

/// Linear light in [0, 1] as an 8-bit level: 255 x^(1/2.2), rounded.
std::uint8_t to_level(double linear);

}  // namespace anyrate
