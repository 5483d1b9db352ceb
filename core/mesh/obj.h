#pragma once
// Wavefront OBJ, the part of it that surfaces need: v, vn and f.
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// "v x y z" with every digit that is needed to get the same doubles back; colours follow as three columns in 0..1 (the
/// habit of MeshLab and others). Unit normals with four decimals, one per vertex and numbered alike.
std::vector<std::byte> encode_obj(const Mesh& mesh);

/// Polygons become fans; negative vertex numbers count back from the last vertex; colours are taken if all vertices
/// have them. Texture coordinates, normals, groups and materials are left out.
/// @throws InputError
Mesh decode_obj(std::span<const std::byte> bytes, std::string_view name);

}  // namespace anyrate
