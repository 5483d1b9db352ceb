#include "gpu/gl_error.h"

#include <epoxy/gl.h>

#include <string>

#include "core/error.h"

namespace anyrate {
namespace {

std::string name_of(GLenum error) {
    switch (error) {
        case GL_INVALID_ENUM:
            return "invalid enum";
        case GL_INVALID_VALUE:
            return "invalid value";
        case GL_INVALID_OPERATION:
            return "invalid operation";
        case GL_INVALID_FRAMEBUFFER_OPERATION:
            return "invalid framebuffer operation";
        case GL_OUT_OF_MEMORY:
            return "the device is out of memory";
        case GL_CONTEXT_LOST:
            return "the context is lost";
        default:
            return "error " + std::to_string(error);
    }
}

}  // namespace

void check_gl(std::string_view call) {
    if (const GLenum error = glGetError(); error != GL_NO_ERROR)
        throw DeviceError("OpenGL, " + std::string(call) + ": " + name_of(error));
}

}  // namespace anyrate
