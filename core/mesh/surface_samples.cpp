#include "core/mesh/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/error.h"
#include "core/mesh/triangle_shape.h"

namespace anyrate {
namespace {

/// Uniform in [0, 1). std::uniform_real_distribution may differ from library to library, the generator may not.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

}  // namespace

SurfaceSamples sample_surface(const Mesh& mesh, int n, std::uint64_t seed) {
    std::vector<double> area_up_to;
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        sum += twice_area_vector(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]).norm();
        area_up_to.push_back(sum);
    }
    if (!(sum > 0)) throw InputError("sample: expected a surface with an area");
    std::mt19937_64 random(seed);
    SurfaceSamples samples;
    samples.points.reserve(static_cast<std::size_t>(n));
    samples.faces.reserve(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) {
        const auto above = std::ranges::upper_bound(area_up_to, uniform(random) * sum) - area_up_to.begin();
        const std::size_t face = std::min<std::size_t>(above, mesh.triangles.size() - 1);
        const auto& [a, b, c] = mesh.triangles[face];
        // The square root makes up for the triangle's growing width from corner a to the side bc.
        const double s = std::sqrt(uniform(random)), t = uniform(random);
        samples.points.push_back((1 - s) * mesh.vertices[a] + s * (1 - t) * mesh.vertices[b] +
                                 s * t * mesh.vertices[c]);
        samples.faces.push_back(static_cast<std::int32_t>(face));
    }
    return samples;
}

}  // namespace anyrate
