#pragma once
#include <map>
#include <string>
#include <string_view>

namespace anyrate {

/// A request target taken apart, percent-decoded.
struct Target {
    std::string path;
    std::map<std::string, std::string> query;
};

/// Parses the origin form or the absolute form of a request target (RFC 9112, 3.2.1 and 3.2.2). A parameter may stand
/// once.
/// @throws HttpProblem 400, or 414 beyond 4096 bytes
Target parse_target(std::string_view target);

}  // namespace anyrate
