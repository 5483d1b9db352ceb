#include "gpu/egl_context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <cstdlib>
#include <vector>

#include "core/error.h"
#include "gpu/egl_display.h"

namespace anyrate {

struct EglContext::Handles {
    explicit Handles(EGLDisplay on) : display(on) {}
    ~Handles() {
        if (context == EGL_NO_CONTEXT) return;
        if (eglGetCurrentContext() == context)
            eglMakeCurrent(display.get(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(display.get(), context);
    }
    Handles(const Handles&) = delete;
    Handles& operator=(const Handles&) = delete;

    EglDisplay display;
    EGLContext context = EGL_NO_CONTEXT;
};

namespace {

/// Any configuration will do, since nothing is drawn on a surface.
EGLConfig config_of(EGLDisplay display) {
    if (epoxy_has_egl_extension(display, "EGL_KHR_no_config_context")) return EGL_NO_CONFIG_KHR;
    const std::array<EGLint, 3> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint n_configs = 0;
    if (eglChooseConfig(display, wanted.data(), &config, 1, &n_configs) != EGL_TRUE || n_configs < 1)
        throw DeviceError("eglChooseConfig: no configuration for OpenGL, " + egl_error());
    return config;
}

/// A context that tells when it is lost, if the driver has such, else one that does not.
EGLContext create_context(EGLDisplay display) {
    const EGLConfig config = config_of(display);
    std::vector<EGLint> attributes{EGL_CONTEXT_MAJOR_VERSION,
                                   4,
                                   EGL_CONTEXT_MINOR_VERSION,
                                   5,
                                   EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                   EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                   EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY,
                                   EGL_LOSE_CONTEXT_ON_RESET,
                                   EGL_NONE};
    EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
    if (context != EGL_NO_CONTEXT) return context;
    attributes.resize(6);
    attributes.push_back(EGL_NONE);
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
    if (context == EGL_NO_CONTEXT) throw DeviceError("eglCreateContext: no OpenGL 4.5 core context, " + egl_error());
    return context;
}

void make_current_on(EGLDisplay display, EGLContext context) {
    if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) != EGL_TRUE)
        throw DeviceError("eglMakeCurrent: " + egl_error());
}

GraphicsDevice describe() {
    const auto text = [](GLenum name) {
        const GLubyte* string = glGetString(name);
        return string == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(string));
    };
    GraphicsDevice device{text(GL_RENDERER), text(GL_VENDOR), text(GL_VERSION), false};
    for (const char* name : {"llvmpipe", "softpipe", "SwiftShader", "swrast", "SWR"})
        device.is_software = device.is_software || device.renderer.find(name) != std::string::npos;
    return device;
}

/// epoxy looks a function up when it is first called, and ends the program if no context is current then. What is
/// called with a context that may have been lost is looked up here.
void look_up_late_calls() {
    glGetGraphicsResetStatus();
    glDeleteBuffers(0, nullptr);
    glDeleteTextures(0, nullptr);
    glDeleteProgram(0);
    glDeleteShader(0);
    glDeleteQueries(0, nullptr);
}

}  // namespace

EglContext::EglContext(DeviceChoice choice) {
    std::string said;
    for (const DisplayCandidate& candidate : display_candidates()) {
        if (choice == DeviceChoice::hardware && candidate.is_software) {
            said += "; " + candidate.name + " computes on the CPU";
            continue;
        }
        try {
            auto handles = std::make_unique<Handles>(candidate.display);
            const EGLDisplay display = handles->display.get();
            if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) throw DeviceError("eglBindAPI: " + egl_error());
            handles->context = create_context(display);
            make_current_on(display, handles->context);
            device_ = describe();
            if (choice == DeviceChoice::hardware && device_.is_software)
                throw DeviceError(device_.renderer + " computes on the CPU");
            look_up_late_calls();
            handles_ = std::move(handles);
            return;
        } catch (const DeviceError& error) {
            said += "; " + candidate.name + ": " + error.what();
        }
    }
    throw DeviceError(std::string(choice == DeviceChoice::hardware ? "no GPU" : "no device") + " with OpenGL 4.5" +
                      said);
}

EglContext::~EglContext() = default;

void EglContext::make_current() {
    if (eglGetCurrentContext() == handles_->context) return;
    if (std::this_thread::get_id() != owner_)
        throw DeviceError("the OpenGL context belongs to another thread than the one that uses it");
    make_current_on(handles_->display.get(), handles_->context);
}

void EglContext::make_none_current() {
    const EGLDisplay display = eglGetCurrentDisplay();
    if (display != EGL_NO_DISPLAY) eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

}  // namespace anyrate
