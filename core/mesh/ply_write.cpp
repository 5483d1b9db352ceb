#include <string>

#include "core/mesh/bounds.h"
#include "core/mesh/little_endian.h"
#include "core/mesh/normals.h"
#include "core/mesh/ply.h"

namespace anyrate {
namespace {

std::string header(const Mesh& mesh, std::string_view position_type) {
    std::string text = "ply\nformat binary_little_endian 1.0\n";
    text += "element vertex " + std::to_string(mesh.n_vertices()) + "\n";
    for (const char* axis : {"x", "y", "z"}) text += "property " + std::string(position_type) + " " + axis + "\n";
    for (const char* axis : {"nx", "ny", "nz"}) text += "property float " + std::string(axis) + "\n";
    if (!mesh.colours.empty())
        for (const char* channel : {"red", "green", "blue"}) text += "property uchar " + std::string(channel) + "\n";
    text += "element face " + std::to_string(mesh.n_faces()) + "\n";
    return text + "property list uchar int vertex_indices\nend_header\n";
}

}  // namespace

std::vector<std::byte> encode_ply(const Mesh& mesh) {
    const bool as_floats = floats_suffice(mesh);
    const std::string text = header(mesh, as_floats ? "float" : "double");
    std::vector<std::byte> bytes;
    const std::vector<Eigen::Vector3f> normals = file_normals(mesh);
    bytes.reserve(text.size() + 39 * mesh.vertices.size() + 13 * mesh.triangles.size());
    for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
    for (int v = 0; v < mesh.n_vertices(); ++v) {
        for (const double x : mesh.vertices[v])
            as_floats ? put_little_endian(bytes, static_cast<float>(x)) : put_little_endian(bytes, x);
        for (const float x : normals[v]) put_little_endian(bytes, x);
        if (mesh.colours.empty()) continue;
        const Rgb8 colour = mesh.colours[v];
        for (const auto channel : {colour.r, colour.g, colour.b}) put_little_endian(bytes, channel);
    }
    for (const Triangle& t : mesh.triangles) {
        put_little_endian(bytes, std::uint8_t{3});
        for (const auto v : t) put_little_endian(bytes, v);
    }
    return bytes;
}

}  // namespace anyrate
