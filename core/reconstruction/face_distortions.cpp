#include "core/reconstruction/face_distortions.h"

#include <algorithm>

namespace anyrate {

FaceDistortions::FaceDistortions(PhotoBackend& backend, const Mesh& mesh) : backend_(&backend) {
    backend_->set_surface(mesh, 0, 1.0);
    faces_ = backend_->distortions(whole_surface(mesh));
}

void FaceDistortions::measure_around(std::span<const std::int32_t> moved, const Mesh& mesh, const OneRings& rings) {
    const std::vector<std::int32_t> around = faces_around(rings, moved);
    std::vector<TriangleQuery> queries;
    for (const std::int32_t f : around) queries.push_back(query_of(mesh, f));
    backend_->set_surface(mesh, 0, 1.0, around);
    const std::vector<TriangleDistortion> measured = backend_->distortions(queries);
    for (std::size_t i = 0; i < around.size(); ++i) faces_[static_cast<std::size_t>(around[i])] = measured[i];
}

std::vector<std::optional<double>> FaceDistortions::of_vertices(const OneRings& rings, int n_vertices) const {
    return vertex_distortion(rings, n_vertices, faces_);
}

std::optional<double> usual_distortion(std::span<const std::optional<double>> G, std::span<const char> left_out) {
    std::vector<double> known;
    for (std::size_t v = 0; v < G.size(); ++v)
        if (left_out[v] == 0 && G[v]) known.push_back(*G[v]);
    if (known.empty()) return std::nullopt;
    const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
    std::nth_element(known.begin(), middle, known.end());
    return *middle;
}

}  // namespace anyrate
