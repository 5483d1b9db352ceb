#include "gpu/depth_pass.h"

#include <string>

#include "gpu/shaders.h"

namespace anyrate {

DepthPass::DepthPass(std::size_t camera_stride)
    : project_("project", shaders::with_common(shaders::project),
               "#define CAMERA_STRIDE " + std::to_string(camera_stride) + "\n"),
      rasterise_("rasterise", shaders::with_common(shaders::rasterise)) {}

void DepthPass::render(const DeviceMesh& mesh, std::size_t n_views, DepthMaps& maps, DeviceWork& work) const {
    maps.screen.reserve(4 * sizeof(float) * n_views * mesh.n_vertices);
    mesh.vertices.bind(0);
    maps.cameras.bind(1);
    maps.screen.bind(2);
    project_.set(0, static_cast<std::int32_t>(mesh.n_vertices));
    work.run(project_, mesh.n_vertices, n_views);

    maps.inverse_depth->clear();
    mesh.triangles.bind(0);
    maps.screen.bind(1);
    maps.sizes.bind(2);
    maps.inverse_depth->bind_image(0);
    rasterise_.set(0, static_cast<std::int32_t>(mesh.n_faces));
    rasterise_.set(1, static_cast<std::int32_t>(mesh.n_vertices));
    work.run(rasterise_, mesh.n_faces, n_views);
}

}  // namespace anyrate
