#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/capture/capture.h"
#include "core/mesh/mesh.h"

namespace anyrate {

struct SimulateOptions {
    int n_views = 22;
    int width = 640, height = 480;
    double noise = 1.0;      ///< sensor noise, standard deviation in 8-bit levels
    std::uint64_t seed = 1;  ///< of the sensor noise and of the cameras' places; a scene's texture is its own
    int supersampling = 3;   ///< samples a pixel, per axis
};

/// A rendered capture and the surface it shows.
struct Simulation {
    Capture capture;
    Mesh ground_truth;  ///< world units, closed, coloured, exactly the mesh that was rendered
};

/// Names of the built-in scenes, the demo's first.
std::vector<std::string> scene_names();

/// Renders a built-in scene, or a mesh with a procedural solid texture, from cameras on a slightly raised circle (every
/// third one a little higher, so that rims and cavities are seen). Lambertian, lighting a function of the normal alone;
/// masks are exact (half of the pixel covered). The same options give the same bytes.
/// @throws InputError for an unknown scene, a mesh that is not closed, fewer than 3 views, images below 16x16 pixels
Simulation simulate_scene(std::string_view scene, const SimulateOptions& options = {});
Simulation simulate_mesh(const Mesh& mesh, const SimulateOptions& options = {});

}  // namespace anyrate
