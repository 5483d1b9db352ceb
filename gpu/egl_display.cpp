#include "gpu/egl_display.h"

#include <algorithm>
#include <array>
#include <map>
#include <mutex>

#include "core/error.h"

namespace anyrate {
namespace {

std::mutex displays_mutex;

std::map<EGLDisplay, int>& display_users() {
    static std::map<EGLDisplay, int> users;
    return users;
}

/// Extensions of EGL itself; all are of EGL 1.5 or asked for by name.
bool has_client_extension(const char* name) { return epoxy_has_egl_extension(EGL_NO_DISPLAY, name); }

bool is_software(EGLDeviceEXT device) {
    const char* extensions = eglQueryDeviceStringEXT(device, EGL_EXTENSIONS);
    return extensions != nullptr && epoxy_extension_in_string(extensions, "EGL_MESA_device_software");
}

std::vector<DisplayCandidate> devices() {
    if (!has_client_extension("EGL_EXT_platform_device") || !has_client_extension("EGL_EXT_device_enumeration"))
        return {};
    std::array<EGLDeviceEXT, 32> found{};
    EGLint n_found = 0;
    if (eglQueryDevicesEXT(static_cast<EGLint>(found.size()), found.data(), &n_found) != EGL_TRUE) return {};
    std::vector<DisplayCandidate> hardware, software;
    for (std::size_t i = 0; i < static_cast<std::size_t>(n_found); ++i) {
        const bool on_cpu = is_software(found[i]);
        const EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, found[i], nullptr);
        if (display == EGL_NO_DISPLAY) continue;
        (on_cpu ? software : hardware).push_back({"device " + std::to_string(i), on_cpu, display});
    }
    hardware.insert(hardware.end(), software.begin(), software.end());
    return hardware;
}

}  // namespace

EglDisplay::EglDisplay(EGLDisplay display) : display_(display) {
    const std::scoped_lock lock(displays_mutex);
    if (eglInitialize(display, nullptr, nullptr) != EGL_TRUE) throw DeviceError("eglInitialize: " + egl_error());
    ++display_users()[display];
}

EglDisplay::~EglDisplay() {
    const std::scoped_lock lock(displays_mutex);
    if (--display_users()[display_] > 0) return;
    display_users().erase(display_);
    eglTerminate(display_);
}

std::vector<DisplayCandidate> display_candidates() {
    if (!epoxy_has_egl()) throw DeviceError("EGL is not installed (libEGL.so.1)");
    std::vector<DisplayCandidate> candidates = devices();
    if (has_client_extension("EGL_MESA_platform_surfaceless")) {
        const EGLDisplay display =
            eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        // It takes one of the devices; where all of them are software, so is it.
        const bool on_cpu = !candidates.empty() && std::ranges::all_of(candidates, &DisplayCandidate::is_software);
        if (display != EGL_NO_DISPLAY) candidates.push_back({"the surfaceless platform", on_cpu, display});
    }
    if (candidates.empty()) throw DeviceError("EGL has no device: no driver is installed");
    return candidates;
}

std::string egl_error() {
    switch (const EGLint error = eglGetError()) {
        case EGL_SUCCESS:
            return "EGL_SUCCESS";
        case EGL_NOT_INITIALIZED:
            return "EGL_NOT_INITIALIZED";
        case EGL_BAD_ACCESS:
            return "EGL_BAD_ACCESS";
        case EGL_BAD_ALLOC:
            return "EGL_BAD_ALLOC";
        case EGL_BAD_ATTRIBUTE:
            return "EGL_BAD_ATTRIBUTE";
        case EGL_BAD_CONTEXT:
            return "EGL_BAD_CONTEXT";
        case EGL_BAD_CONFIG:
            return "EGL_BAD_CONFIG";
        case EGL_BAD_DISPLAY:
            return "EGL_BAD_DISPLAY";
        case EGL_BAD_MATCH:
            return "EGL_BAD_MATCH";
        case EGL_BAD_PARAMETER:
            return "EGL_BAD_PARAMETER";
        case EGL_CONTEXT_LOST:
            return "EGL_CONTEXT_LOST";
        default:
            return "error " + std::to_string(error);
    }
}

}  // namespace anyrate
