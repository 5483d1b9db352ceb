#pragma once
#include <string>
#include <string_view>

namespace anyrate::shaders {

// The texts of shaders/, without `#version`.
extern const std::string_view common;     ///< declarations, before any of the others
extern const std::string_view round;      ///< those of a round of local optimisation
extern const std::string_view workgroup;  ///< sums over a work group that is alone
extern const std::string_view project;
extern const std::string_view rasterise;
extern const std::string_view sights;
extern const std::string_view see;
extern const std::string_view terms;
extern const std::string_view reduce;
extern const std::string_view normals;
extern const std::string_view gather;
extern const std::string_view contours;
extern const std::string_view assemble;
extern const std::string_view solve;
extern const std::string_view move;
extern const std::string_view judge;

inline std::string with_common(std::string_view shader) { return std::string(common) + std::string(shader); }

}  // namespace anyrate::shaders
