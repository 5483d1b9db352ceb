#pragma once
#include <cstdint>

namespace anyrate {

/// Images of one size with unsigned 32-bit pixels, as layers of a texture array with mip levels. Level l + 1 has half
/// the pixels of level l along each axis, rounded down.
class GlTextureArray {
public:
    /// @throws DeviceError the device has no such memory, or takes no such size
    GlTextureArray(int width, int height, int n_layers, int n_levels);
    ~GlTextureArray();
    GlTextureArray(const GlTextureArray&) = delete;
    GlTextureArray& operator=(const GlTextureArray&) = delete;

    /// Copies an image to the lower left corner of a layer. @param pixels  width x height of them, by rows
    void write(int level, int layer, int width, int height, const void* pixels);
    /// Zeros everywhere on level 0.
    void clear();

    /// To the sampler, or of level 0 the image, that a shader declares with `binding = unit`.
    void bind_sampler(std::uint32_t unit) const;
    void bind_image(std::uint32_t unit) const;

private:
    std::uint32_t id_ = 0;
};

}  // namespace anyrate
