#pragma once
#include <string_view>

namespace anyrate::shaders {

// The texts of shaders/, without `#version`; all but `common` start with a comment on what they compute.
extern const std::string_view common;  ///< declarations, before any of the others
extern const std::string_view project;
extern const std::string_view rasterise;
extern const std::string_view sights;
extern const std::string_view see;
extern const std::string_view terms;
extern const std::string_view reduce;

}  // namespace anyrate::shaders
