#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace anyrate {

/// The one spelling of a file's name inside a capture: parts joined by '/', "." parts and doubled slashes left out.
/// @return nullopt if the name is empty or could lead out of the capture: an absolute path, a ".." part, a backslash, a
///         drive letter, or a control character
std::optional<std::string> relative_name(std::string_view name);

}  // namespace anyrate
