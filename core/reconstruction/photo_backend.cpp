#include "core/reconstruction/photo_backend.h"

namespace anyrate {

TriangleQuery query_of(const SurfaceView& surface, std::int32_t face) {
    TriangleQuery query{.face = face, .corners = {}};
    const Triangle& t = surface.triangles[static_cast<std::size_t>(face)];
    for (std::size_t k = 0; k < 3; ++k) query.corners[k] = surface.vertices[static_cast<std::size_t>(t[k])];
    return query;
}

std::vector<TriangleQuery> whole_surface(const SurfaceView& surface) {
    std::vector<TriangleQuery> batch;
    batch.reserve(surface.triangles.size());
    for (std::int32_t f = 0; f < static_cast<std::int32_t>(surface.triangles.size()); ++f)
        batch.push_back(query_of(surface, f));
    return batch;
}

std::vector<std::array<Vec3, 3>> corner_normals(const SurfaceView& surface) {
    const std::vector<Vec3> normals = vertex_normals(surface, OneRings(surface));
    std::vector<std::array<Vec3, 3>> directions;
    directions.reserve(surface.triangles.size());
    for (const auto& [a, b, c] : surface.triangles)
        directions.push_back({normals[static_cast<std::size_t>(a)], normals[static_cast<std::size_t>(b)],
                              normals[static_cast<std::size_t>(c)]});
    return directions;
}

double measure_surface(PhotoBackend& backend, const SurfaceView& surface, double samples_per_px) {
    backend.set_surface(surface, 0, samples_per_px);
    return surface_distortion(backend.distortions(whole_surface(surface)));
}

}  // namespace anyrate
