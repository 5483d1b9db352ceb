#pragma once
#include <functional>
#include <string>

#include "core/reconstruction/photo_backend.h"

namespace anyrate {

/// Called once when a device has failed, with what it said.
using DeviceFailureFn = std::function<void(const std::string& reason)>;

/// A backend that asks another one until that fails with DeviceError (no memory left, a lost context), and the CPU from
/// there on: the call that failed is answered by the CPU, whose current surface is then the same. Gives up the other
/// one with all it holds. Where the other one cannot even be made the CPU has all of the work.
/// @param on_failure  called before the CPU takes over, on the thread that called the backend
BackendFactory with_cpu_fallback(BackendFactory preferred, DeviceFailureFn on_failure);

}  // namespace anyrate
