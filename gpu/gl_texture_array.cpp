#include "gpu/gl_texture_array.h"

#include <epoxy/gl.h>

#include <cmath>
#include <string>

#include "core/error.h"
#include "gpu/gl_error.h"

namespace anyrate {
namespace {

void require_at_most(GLenum limit, int value, const char* what) {
    GLint most = 0;
    glGetIntegerv(limit, &most);
    if (value > most)
        throw DeviceError("OpenGL: this device takes no more than " + std::to_string(most) + " " + what +
                          " in a texture, " + std::to_string(value) + " are needed");
}

/// NVIDIA's driver (580) ends the program when it is asked for terabytes, instead of an error: where a driver says what
/// memory there is, it is asked first.
void require_memory(double n_bytes) {
    if (!epoxy_has_gl_extension("GL_NVX_gpu_memory_info")) return;
    GLint n_kib = 0;
    glGetIntegerv(GL_GPU_MEMORY_INFO_TOTAL_AVAILABLE_MEMORY_NVX, &n_kib);
    const double most = 1024.0 * n_kib;
    if (n_bytes > most)
        throw DeviceError("OpenGL: this device has the memory for " + std::to_string(std::llround(most)) +
                          " bytes, a texture needs " + std::to_string(std::llround(n_bytes)));
}

}  // namespace

GlTextureArray::GlTextureArray(int width, int height, int n_layers, int n_levels) {
    require_at_most(GL_MAX_TEXTURE_SIZE, width, "columns");
    require_at_most(GL_MAX_TEXTURE_SIZE, height, "rows");
    require_at_most(GL_MAX_ARRAY_TEXTURE_LAYERS, n_layers, "layers");
    require_memory(4.0 * width * height * n_layers);  // the coarser levels are a third as much
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id_);
    glTextureStorage3D(id_, n_levels, GL_R32UI, width, height, n_layers);
    glTextureParameteri(id_, GL_TEXTURE_MIN_FILTER, GL_NEAREST_MIPMAP_NEAREST);
    glTextureParameteri(id_, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    try {
        check_gl("glTextureStorage3D of " + std::to_string(width) + " x " + std::to_string(height) + " x " +
                 std::to_string(n_layers) + " pixels");
    } catch (const DeviceError&) {
        glDeleteTextures(1, &id_);
        throw;
    }
}

GlTextureArray::~GlTextureArray() { glDeleteTextures(1, &id_); }

void GlTextureArray::write(int level, int layer, int width, int height, const void* pixels) {
    glTextureSubImage3D(id_, level, 0, 0, layer, width, height, 1, GL_RED_INTEGER, GL_UNSIGNED_INT, pixels);
    check_gl("glTextureSubImage3D");
}

void GlTextureArray::clear() {
    glClearTexImage(id_, 0, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
    check_gl("glClearTexImage");
}

void GlTextureArray::bind_sampler(std::uint32_t unit) const { glBindTextureUnit(unit, id_); }

void GlTextureArray::bind_image(std::uint32_t unit) const {
    glBindImageTexture(unit, id_, 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32UI);
}

}  // namespace anyrate
