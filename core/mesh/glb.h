#pragma once
// Binary glTF 2.0 (Khronos, "glTF 2.0 Specification", sections 3 and 4).
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// One mesh of one primitive: POSITION and NORMAL (area-weighted) as floats, COLOR_0, 32-bit indices, a matt material.
/// glTF wants vertex colours linear, ours are sRGB: they become 16-bit numbers, for 8 linear bits would run the dark
/// tones together. Where floats would not suffice (bounds.h), positions count from the bounding box's centre and the
/// node moves them there. A mesh without triangles is an empty scene.
std::vector<std::byte> encode_glb(const Mesh& mesh);

/// A mesh in the numbers that a GLB file holds.
struct GlbGeometry {
    std::vector<Eigen::Vector3f> positions;             ///< from the node's place
    std::vector<Eigen::Vector3f> normals;               ///< unit
    std::vector<std::array<std::uint16_t, 3>> colours;  ///< linear, 65535 for 1; empty, or one per vertex
    std::span<const Triangle> triangles;
};

/// A geometry as one Draco string, as KHR_draco_mesh_compression describes it: positions, normals and colours are VEC3
/// of floats, and counts and bounds are those that its decoder finds.
struct DracoGeometry {
    std::vector<std::byte> bytes;
    int position_id = 0, normal_id = 0;  ///< of the attributes in the string
    std::optional<int> colour_id;
    int n_vertices = 0, n_faces = 0;
    Eigen::AlignedBox3f bounds;
};
using CompressGeometry = std::function<DracoGeometry(const GlbGeometry&)>;

/// The same file with its geometry compressed; readers need KHR_draco_mesh_compression. (Draco itself stays out of
/// here: proto/draco_glb.h.)
std::vector<std::byte> encode_glb(const Mesh& mesh, const CompressGeometry& compress);

}  // namespace anyrate
