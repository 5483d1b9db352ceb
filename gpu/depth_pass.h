#pragma once
#include <optional>

#include "gpu/device_work.h"
#include "gpu/gl_texture_array.h"

namespace anyrate {

/// Depth maps of all views, with what they were rendered by.
struct DepthMaps {
    GlBuffer cameras;  ///< P by rows at the start of each view's numbers
    GlBuffer sizes;    ///< width and height of each view's map, pixels; of a surface's then far_part() of each, as bits
    GlBuffer screen;   ///< every vertex as every view sees it, by views: pixel and 1 / depth
    std::optional<GlTextureArray>
        inverse_depth;  ///< bits of a float, 1 / world units along the optical axis; 0: nothing
};

/// A triangle mesh on the device: three doubles a vertex, three indices a triangle.
struct DeviceMesh {
    const GlBuffer &vertices, &triangles;
    std::size_t n_vertices = 0, n_faces = 0;
};

/// Renders depth for all views in one pass, to the layers of a texture array; as render_inverse_depth() of
/// inverse_depth.h, operation by operation.
class DepthPass {
public:
    /// @param camera_stride  numbers a view has in DepthMaps::cameras. @throws DeviceError
    explicit DepthPass(std::size_t camera_stride);

    /// @param maps  with cameras, sizes and textures. @throws DeviceError
    void render(const DeviceMesh& mesh, std::size_t n_views, DepthMaps& maps, DeviceWork& work) const;

private:
    GlProgram project_, rasterise_;
};

}  // namespace anyrate
