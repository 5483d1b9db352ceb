#include "core/reconstruction/state_attributes.h"

#include <numeric>

#include "core/parallel.h"
#include "core/reconstruction/vertex_colours.h"

namespace anyrate {
namespace {

/// @param visibility  of the mesh, or nullptr
std::vector<Rgb8> colours_from(std::int32_t first, const PhotoImages& images, const Mesh& mesh, int n_vertices,
                               const Visibility* visibility) {
    std::vector<std::int32_t> vertices(static_cast<std::size_t>(mesh.n_vertices() - first));
    std::iota(vertices.begin(), vertices.end(), first);
    return vertex_colours(images, mesh, vertex_spacing(mesh, n_vertices), vertices, visibility);
}

}  // namespace

StateAttributes state_attributes(PhotoBackend& backend, const PhotoImages& images, const RefinableMesh& state,
                                 std::int32_t first, const RefineOptions& options) {
    const Mesh mesh = state.to_mesh();
    const SurfaceView surface(mesh);
    backend.set_surface(surface, 0, options.samples_per_px);
    const Visibility* const visibility = backend.visibility();
    StateAttributes result;
    run_beside([&] { result.colours = colours_from(first, images, mesh, options.n_vertices, visibility); },
               [&] { result.distortion = current_distortion(backend, surface); });
    return result;
}

std::vector<Rgb8> state_colours(const PhotoImages& images, const RefinableMesh& state, std::int32_t first,
                                const RefineOptions& options) {
    return colours_from(first, images, state.to_mesh(), options.n_vertices, nullptr);
}

}  // namespace anyrate
