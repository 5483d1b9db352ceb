#pragma once
#include <string_view>

namespace anyrate {

/// Asks the driver whether all went well so far.
/// @param call  what was called, for the message
/// @throws DeviceError it did not: out of memory, the context is lost, or a fault of ours
void check_gl(std::string_view call);

/// The same, and whether the device was reset meanwhile, which a driver may tell by its status alone. For calls that
/// waited for the device: what they brought is nothing then.
/// @throws DeviceError
void check_gl_and_reset(std::string_view call);

}  // namespace anyrate
