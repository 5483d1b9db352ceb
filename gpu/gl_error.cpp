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

void check_gl_and_reset(std::string_view call) {
    check_gl(call);
    // By GL_KHR_robustness, part of OpenGL 4.5.
    const GLenum status = glGetGraphicsResetStatus();
    if (status == GL_NO_ERROR) return;
    const char* const whose = status == GL_GUILTY_CONTEXT_RESET     ? "by what this context did"
                              : status == GL_INNOCENT_CONTEXT_RESET ? "by what another context did"
                                                                    : "for a reason that it does not know";
    throw DeviceError("OpenGL, " + std::string(call) + ": the context is lost, the device was reset " + whose);
}

}  // namespace anyrate
