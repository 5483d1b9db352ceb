#pragma once
#include <string_view>

namespace anyrate {

/// proto/openapi.yaml, put into the program by the build.
std::string_view openapi_document();
/// The same as JSON.
std::string_view openapi_document_json();

}  // namespace anyrate
