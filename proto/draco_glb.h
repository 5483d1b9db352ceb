#pragma once
#include <cstddef>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// A GLB file (core/mesh/glb.h) whose geometry is compressed by Draco (KHR_draco_mesh_compression): positions to
/// 1/65535 of the longest side of the bounding box, as finely as a log's grid, normals to about a fifth of a degree,
/// colours to 12 linear bits, which tell all 256 sRGB tones apart. Vertices and faces are numbered anew.
/// @throws InputError if Draco finds nothing to encode: no triangle has three different corners
std::vector<std::byte> encode_draco_glb(const Mesh& mesh);

}  // namespace anyrate
