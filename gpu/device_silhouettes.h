#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/reconstruction/silhouette_term.h"
#include "gpu/depth_pass.h"

namespace anyrate {

/// Silhouettes on the device: the distances to the masks' borders, copied once, and what the surface covers.
class DeviceSilhouettes {
public:
    /// @throws DeviceError
    DeviceSilhouettes();

    /// Makes these the ones that are asked, with their cameras as they stand. @throws DeviceError
    void set(const Silhouettes& silhouettes, DeviceWork& work);

    /// As Silhouettes::look(). @throws DeviceError
    void look(const DeviceMesh& mesh, DeviceWork& work);

    std::size_t n_views() const { return on_device_.size(); }
    const GlBuffer& cameras() const { return cameras_; }  ///< as shaders/contours.comp reads them
    /// To the samplers of shaders/contours.comp.
    void bind_textures() const;

private:
    void copy_distances(const Silhouettes& silhouettes, DeviceWork& work);

    DepthPass depth_pass_;
    DepthMaps coverage_;
    int coverage_width_ = 0, coverage_height_ = 0;
    GlBuffer cameras_;
    std::vector<std::shared_ptr<const Image<std::int8_t>>> on_device_;  ///< kept, so that no other gets its address
    std::optional<GlTextureArray> distances_;
};

}  // namespace anyrate
