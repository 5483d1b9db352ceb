#pragma once
#include <string_view>

namespace anyrate {

/// proto/openapi.yaml, put into the program by the build.
std::string_view openapi_document();

}  // namespace anyrate
