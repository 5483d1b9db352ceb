#include "core/reconstruction/photo_backend.h"

namespace anyrate {

std::vector<TriangleQuery> whole_surface(const SurfaceView& surface) {
    std::vector<TriangleQuery> batch(surface.triangles.size());
    for (std::size_t f = 0; f < batch.size(); ++f) {
        batch[f].face = static_cast<std::int32_t>(f);
        for (std::size_t k = 0; k < 3; ++k)
            batch[f].corners[k] = surface.vertices[static_cast<std::size_t>(surface.triangles[f][k])];
    }
    return batch;
}

double measure_surface(PhotoBackend& backend, const SurfaceView& surface, double samples_per_px) {
    backend.set_surface(surface, 0, samples_per_px);
    return surface_distortion(backend.distortions(whole_surface(surface)));
}

}  // namespace anyrate
