#pragma once
// The polygon file format, as Greg Turk defined it at Stanford in 1994.
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Binary little-endian: x y z as floats, or as doubles where floats would not suffice (bounds.h), unit normals as
/// floats nx ny nz, colours as uchar red green blue, faces as "list uchar int vertex_indices".
std::vector<std::byte> encode_ply(const Mesh& mesh);

/// Ascii and binary of both byte orders, any number types; polygons become fans, what else the file holds is skipped.
/// Memory stays in proportion to the bytes given, whatever the header says.
/// @throws InputError
Mesh decode_ply(std::span<const std::byte> bytes, std::string_view name);

}  // namespace anyrate
