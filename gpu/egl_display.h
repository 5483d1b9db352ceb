#pragma once
#include <epoxy/egl.h>

#include <string>
#include <vector>

namespace anyrate {

/// A display of EGL that is initialised as long as somebody holds it: EGL has one display a device, and ending it ends
/// it for all.
class EglDisplay {
public:
    /// @throws DeviceError it cannot be initialised
    explicit EglDisplay(EGLDisplay display);
    ~EglDisplay();
    EglDisplay(const EglDisplay&) = delete;
    EglDisplay& operator=(const EglDisplay&) = delete;

    EGLDisplay get() const { return display_; }

private:
    EGLDisplay display_;
};

/// Where a context may be made.
struct DisplayCandidate {
    std::string name;          ///< for messages
    bool is_software = false;  ///< known to compute on the CPU; false may also be unknown
    EGLDisplay display = EGL_NO_DISPLAY;
};

/// The devices of EGL, hardware before software, and the surfaceless platform behind them.
/// @throws DeviceError there is no EGL on this machine
std::vector<DisplayCandidate> display_candidates();

/// The last error of EGL on this thread, as its name.
std::string egl_error();

}  // namespace anyrate
