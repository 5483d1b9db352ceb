#pragma once
#include <memory>

#include "core/reconstruction/photo_backend.h"
#include "gpu/device_work.h"
#include "gpu/egl_context.h"

namespace anyrate {

/// The PhotoBackend that computes on an OpenGL device. Its results agree with the CPU's to a relative 1e-4, rounds of
/// local optimisation to a thousandth of a pixel, and are the same bytes each time on one device and driver. A round is
/// one round trip, however many steps it takes and refuses. It belongs to the thread that made it.
/// Every call but pixel_size() and n_levels() may throw DeviceError; after that only the destructor may be called.
class GpuBackend : public PhotoBackend {
public:
    /// What it had the device do so far.
    virtual const DeviceWork& work() const = 0;
    /// Waits until the device has done it.
    virtual void finish() = 0;
};

/// Copies the photographs to the device.
/// @param context  of this thread
/// @param images   must outlive it; the cameras may move between two calls of set_surface(), the pixels stay
/// @throws DeviceError
std::unique_ptr<GpuBackend> make_gpu_backend(std::shared_ptr<EglContext> context, const PhotoImages& images,
                                             Sampling sampling = Sampling::adaptive);

}  // namespace anyrate
