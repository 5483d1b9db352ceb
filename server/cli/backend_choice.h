#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "core/reconstruction/photo_backend.h"

namespace anyrate {

/// What `--backend` asks for.
enum class BackendKind {
    automatic,  ///< a GPU if there is one, never one that is made of software; else the CPU
    cpu,
    gpu,  ///< an OpenGL device, made of software if there is no other
};
const std::map<std::string, BackendKind>& backend_kinds();

/// Who computes photo-consistency in a run, and what is to be said of it.
struct BackendChoice {
    BackendFactory factory;
    std::string device;        ///< as its driver names it; empty: the CPU
    bool is_hardware = false;  ///< the device is a GPU, not software in its place
    std::string sentence;      ///< for the user: what was taken and, where a GPU was looked for in vain, why

    /// Who has computed so far: "cpu", "gpu", or "gpu, then cpu" where the device failed in the middle.
    std::function<std::string()> name;
};

/// Looks for it and, if it is a device, holds it for this thread, on which the factory is to be called.
/// @param warn  told when the device fails and the CPU goes on
/// @throws DeviceError BackendKind::gpu, and there is no device with OpenGL 4.5
BackendChoice choose_backend(BackendKind kind, std::function<void(const std::string& sentence)> warn);

}  // namespace anyrate
