#pragma once
#include <cstdint>
#include <string_view>

#include "core/encoding/encode_mesh.h"
#include "core/reconstruction/reconstruct.h"

namespace anyrate {

/// The identity of the log that this capture and these options give: equal inputs have equal ids, so that the same
/// command gives the same file, and others practically never do. A 64-bit hash of every pixel and camera.
/// @param device  whose arithmetic chose the operations; empty: the CPU's, which is the same everywhere
std::uint64_t log_id_of(const Capture& capture, const ReconstructOptions& options, std::string_view device = {});

/// The same for the log that this mesh and these options give.
std::uint64_t log_id_of(const Mesh& mesh, const EncodeMeshOptions& options);

}  // namespace anyrate
