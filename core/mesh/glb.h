#pragma once
// Binary glTF 2.0 (Khronos, "glTF 2.0 Specification", sections 3 and 4).
#include <cstddef>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// One mesh of one primitive: POSITION and NORMAL (area-weighted) as floats, COLOR_0, 32-bit indices, a matt material.
/// glTF wants vertex colours linear, ours are sRGB: they become 16-bit numbers, for 8 linear bits would run the dark
/// tones together. Where floats would not suffice (bounds.h), positions count from the bounding box's centre and the
/// node moves them there. A mesh without triangles is an empty scene.
std::vector<std::byte> encode_glb(const Mesh& mesh);

}  // namespace anyrate
