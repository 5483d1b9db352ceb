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

std::vector<Vec3> sample_surface(const Mesh& mesh, int n, std::uint64_t seed) {
    std::vector<double> area_up_to;
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        sum += twice_area_vector(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]).norm();
        area_up_to.push_back(sum);
    }
    if (!(sum > 0)) throw InputError("sample: expected a surface with an area");
    std::mt19937_64 random(seed);
    std::vector<Vec3> points;
    points.reserve(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) {
        const auto face = std::ranges::upper_bound(area_up_to, uniform(random) * sum) - area_up_to.begin();
        const auto& [a, b, c] = mesh.triangles[std::min<std::size_t>(face, mesh.triangles.size() - 1)];
        // The square root makes up for the triangle's growing width from corner a to the side bc.
        const double s = std::sqrt(uniform(random)), t = uniform(random);
        points.push_back((1 - s) * mesh.vertices[a] + s * (1 - t) * mesh.vertices[b] + s * t * mesh.vertices[c]);
    }
    return points;
}

}  // namespace anyrate
