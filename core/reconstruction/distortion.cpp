#include "core/reconstruction/distortion.h"

namespace anyrate {

std::vector<std::optional<double>> vertex_distortion(const OneRings& rings, int n_vertices,
                                                     std::span<const TriangleDistortion> triangles) {
    std::vector<std::optional<double>> G(static_cast<std::size_t>(n_vertices));
    for (std::int32_t v = 0; v < n_vertices; ++v) {
        TriangleDistortion ring;
        for (std::int32_t f : rings.faces(v)) {
            ring.phi += triangles[static_cast<std::size_t>(f)].phi;
            ring.n_samples += triangles[static_cast<std::size_t>(f)].n_samples;
        }
        // Nghiem et al., Eq. 9.
        if (ring.n_samples > 0) G[static_cast<std::size_t>(v)] = ring.phi / ring.n_samples;
    }
    return G;
}

double surface_distortion(std::span<const TriangleDistortion> triangles) {
    double phi = 0.0, n_samples = 0.0;
    for (const TriangleDistortion& t : triangles) {
        phi += t.phi;
        n_samples += t.n_samples;
    }
    // Nghiem et al., Eq. 10.
    return n_samples > 0 ? phi / n_samples : 0.0;
}

}  // namespace anyrate
