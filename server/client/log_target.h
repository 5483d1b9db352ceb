#pragma once
#include <string>

namespace anyrate {

/// The target of a model's log if `target` is a model's, else `target`.
std::string log_target(const std::string& target);
/// Where the side index of a live log is: .../index?form=live on a server, for the log may be sealed at any moment and
/// have other rows then; <log>.idx beside a file.
std::string index_target(const std::string& log_target);

}  // namespace anyrate
