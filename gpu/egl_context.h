#pragma once
#include <memory>
#include <string>
#include <thread>

namespace anyrate {

/// What draws: the names that its driver gives it.
struct GraphicsDevice {
    std::string renderer, vendor, version;
    bool is_software = false;  ///< a rasteriser on the CPU, as Mesa's llvmpipe
};

/// Which devices will do.
enum class DeviceChoice {
    hardware,  ///< a GPU
    any,       ///< a GPU if there is one, else software
};

/// An OpenGL 4.5 core context without a window: on a device of EGL (EGL_EXT_platform_device), hardware before software,
/// or where no device can be asked for on Mesa's surfaceless platform. It belongs to the thread that made it; several
/// may exist at a time.
class EglContext {
public:
    /// Makes it, current on this thread.
    /// @throws DeviceError there is no such device, with what each that was tried said
    explicit EglContext(DeviceChoice choice);
    ~EglContext();
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;

    const GraphicsDevice& device() const { return device_; }

    /// Makes it current again, if another context was meanwhile.
    /// @throws DeviceError the context is lost, or this is another thread
    void make_current();

    /// Leaves this thread without a current context: what is deleted then is deleted nowhere.
    static void make_none_current();

private:
    struct Handles;
    std::unique_ptr<Handles> handles_;
    GraphicsDevice device_;
    std::thread::id owner_ = std::this_thread::get_id();
};

}  // namespace anyrate
