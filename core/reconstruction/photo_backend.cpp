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

double measure_surface(PhotoBackend& backend, const SurfaceView& surface, double samples_per_px) {
    backend.set_surface(surface, 0, samples_per_px);
    return surface_distortion(backend.distortions(whole_surface(surface)));
}

}  // namespace anyrate
