#pragma once
#include <cstdlib>
#include <span>

#include "core/error.h"
#include "core/mesh/mesh_io.h"

namespace anyrate {

/// Decodes; what comes back must keep the promises of Mesh and survive being written and read again.
inline void decode_and_check(std::span<const std::byte> bytes, MeshFormat format) {
    try {
        const Mesh mesh = decode_mesh_file(bytes, format, "fuzz");
        for (const Vec3& v : mesh.vertices)
            if (!v.allFinite()) std::abort();
        for (const Triangle& t : mesh.triangles)
            for (const auto v : t)
                if (v < 0 || v >= mesh.n_vertices()) std::abort();
        if (!mesh.colours.empty() && mesh.colours.size() != mesh.vertices.size()) std::abort();
        const Mesh again = decode_mesh_file(encode_mesh_file(mesh, format), format, "again");
        if (again.triangles != mesh.triangles || again.colours != mesh.colours) std::abort();
    } catch (const InputError&) {  // the bytes were no mesh
    }
}

}  // namespace anyrate
