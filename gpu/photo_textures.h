#pragma once
#include <vector>

#include "core/reconstruction/photo_images.h"
#include "gpu/device_work.h"
#include "gpu/gl_texture_array.h"

namespace anyrate {

/// The photographs of all views on the device: a layer a view, and the levels of their pyramids as they are, since a
/// driver's own reduction would neither mind the masks nor give the same bytes everywhere.
class PhotoTextures {
public:
    /// Copies them. @throws DeviceError
    PhotoTextures(const PhotoImages& images, DeviceWork& work);

    void bind(std::uint32_t unit) const { texture_.bind_sampler(unit); }

private:
    GlTextureArray texture_;
};

constexpr std::size_t camera_block_stride = 16;

/// The cameras of a level as shaders read them, camera_block_stride numbers a view: P by rows, the centre of
/// projection, and what the caller knows of each view.
/// @param of_view  one a view
std::vector<double> camera_block(const PhotoImages& images, int level, std::span<const double> of_view);

/// Width and height of each view's image at a level.
std::vector<std::int32_t> size_block(const PhotoImages& images, int level);

}  // namespace anyrate
