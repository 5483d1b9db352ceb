#include "core/mesh/true_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>

#include "core/mesh/surface_samples.h"
#include "core/mesh/triangle_shape.h"

namespace anyrate {
namespace {

constexpr std::uint64_t sample_seed = 1;

}  // namespace

TrueSurface::TrueSurface(const Mesh& mesh, int n_samples) : nearest(mesh) {
    face_normals.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3 twice_area = twice_area_vector(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
        area += 0.5 * twice_area.norm();
        face_normals.push_back(twice_area.stableNormalized());
    }
    SurfaceSamples sampled = sample_surface(mesh, n_samples, sample_seed);
    samples = std::move(sampled.points);
    sample_faces = std::move(sampled.faces);
    samples_in_tour.resize(samples.size());
    std::iota(samples_in_tour.begin(), samples_in_tour.end(), 0);
    std::ranges::stable_sort(samples_in_tour, {}, [&](std::int32_t i) { return nearest.place(sample_faces[i]); });
}

}  // namespace anyrate
