#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

enum class MeshFormat { ply, obj, glb };

/// The format a file name's extension stands for.
/// @throws InputError for any extension but .ply, .obj, .glb
MeshFormat mesh_format(const std::filesystem::path& file);

/// A mesh as the bytes of a file: binary little-endian PLY (positions float, or double where floats would lose more
/// than a millionth of the diagonal), OBJ, or GLB 2.0, each with normals and, if the mesh has them, colours. The same
/// mesh always gives the same bytes.
std::vector<std::byte> encode_mesh_file(const Mesh& mesh, MeshFormat format);

/// Reads PLY (ascii or binary, polygons are fanned) or OBJ. `name` is for messages.
/// @throws InputError saying what the bytes should have been
Mesh decode_mesh_file(std::span<const std::byte> bytes, MeshFormat format, std::string_view name);

/// The same, from and to a file by its extension. @throws IoError, InputError
Mesh read_mesh(const std::filesystem::path& file);
void write_mesh(const Mesh& mesh, const std::filesystem::path& file);

}  // namespace anyrate
