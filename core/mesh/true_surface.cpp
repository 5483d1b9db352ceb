#include "core/mesh/true_surface.h"

#include <Eigen/Geometry>

#include "core/mesh/surface_samples.h"
#include "core/mesh/triangle_shape.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

constexpr std::uint64_t sample_seed = 1;

}  // namespace

TrueSurface::TrueSurface(const Mesh& mesh, int n_samples)
    : nearest(mesh), samples(sample_surface(mesh, n_samples, sample_seed)) {
    face_normals.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3 twice_area = twice_area_vector(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
        area += 0.5 * twice_area.norm();
        face_normals.push_back(twice_area.stableNormalized());
    }
    sample_normals.resize(samples.size());
    parallel_for(samples.size(),
                 [&](std::size_t i) { sample_normals[i] = face_normals[nearest.nearest(samples[i]).face]; });
}

}  // namespace anyrate
