#include "proto/draco_glb.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <array>
#include <string>

#include "core/error.h"
#include "core/mesh/glb.h"

namespace anyrate {

namespace {

constexpr int position_bits = 16, normal_bits = 10, colour_bits = 12;

[[noreturn]] void fail(const draco::Status& status) { throw InputError("Draco: " + status.error_msg_string()); }

/// Adds an attribute of three floats per vertex; `vector(v)` gives those of vertex v. @return its number
template <class VectorOf>
int add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, std::size_t n_vertices, VectorOf vector) {
    draco::GeometryAttribute description;
    description.Init(type, nullptr, 3, draco::DT_FLOAT32, false, 3 * sizeof(float), 0);
    const int id = mesh.AddAttribute(description, true, static_cast<std::uint32_t>(n_vertices));
    for (std::size_t v = 0; v < n_vertices; ++v) {
        const std::array<float, 3> value = vector(v);
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(v)), value.data());
    }
    return id;
}

void set_faces(draco::Mesh& mesh, std::span<const Triangle> triangles) {
    mesh.SetNumFaces(triangles.size());
    for (std::size_t f = 0; f < triangles.size(); ++f) {
        const auto corner = [&](std::size_t i) {
            return draco::PointIndex(static_cast<std::uint32_t>(triangles[f][i]));
        };
        mesh.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(f)), {corner(0), corner(1), corner(2)});
    }
}

std::vector<std::byte> encode(const GlbGeometry& geometry) {
    const std::size_t n_vertices = geometry.positions.size();
    draco::Mesh mesh;
    mesh.set_num_points(static_cast<std::uint32_t>(n_vertices));
    set_faces(mesh, geometry.triangles);
    const auto of = [](const std::vector<Eigen::Vector3f>& vectors) {
        return [&vectors](std::size_t v) { return std::array{vectors[v].x(), vectors[v].y(), vectors[v].z()}; };
    };
    const int position = add_attribute(mesh, draco::GeometryAttribute::POSITION, n_vertices, of(geometry.positions));
    const int normal = add_attribute(mesh, draco::GeometryAttribute::NORMAL, n_vertices, of(geometry.normals));
    std::optional<int> colour;
    if (!geometry.colours.empty()) {
        colour = add_attribute(mesh, draco::GeometryAttribute::COLOR, n_vertices, [&](std::size_t v) {
            const auto& [r, g, b] = geometry.colours[v];
            return std::array{static_cast<float>(r) / 65535.0F, static_cast<float>(g) / 65535.0F,
                              static_cast<float>(b) / 65535.0F};
        });
    }
    draco::ExpertEncoder encoder(mesh);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetSpeedOptions(0, 0);
    encoder.SetAttributeQuantization(position, position_bits);
    encoder.SetAttributeQuantization(normal, normal_bits);
    constexpr std::array<float, 3> black = {0, 0, 0};
    if (colour) encoder.SetAttributeExplicitQuantization(*colour, colour_bits, 3, black.data(), 1.0F);
    draco::EncoderBuffer buffer;
    if (const draco::Status status = encoder.EncodeToBuffer(&buffer); !status.ok()) fail(status);
    const auto* data = reinterpret_cast<const std::byte*>(buffer.data());
    return {data, data + buffer.size()};
}

/// What a decoder finds in the string: Draco leaves out vertices without a face and doubles those of two fans.
DracoGeometry described(std::vector<std::byte> bytes, bool has_colours) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) fail(decoded.status());
    const draco::Mesh& mesh = *decoded.value();
    const auto id_of = [&](draco::GeometryAttribute::Type type) {
        return static_cast<int>(mesh.GetNamedAttribute(type)->unique_id());
    };
    DracoGeometry geometry;
    geometry.bytes = std::move(bytes);
    geometry.position_id = id_of(draco::GeometryAttribute::POSITION);
    geometry.normal_id = id_of(draco::GeometryAttribute::NORMAL);
    if (has_colours) geometry.colour_id = id_of(draco::GeometryAttribute::COLOR);
    geometry.n_vertices = static_cast<int>(mesh.num_points());
    geometry.n_faces = static_cast<int>(mesh.num_faces());
    const draco::PointAttribute& positions = *mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
        Eigen::Vector3f p;
        positions.GetMappedValue(point, p.data());
        geometry.bounds.extend(p);
    }
    return geometry;
}

}  // namespace

std::vector<std::byte> encode_draco_glb(const Mesh& mesh) {
    return encode_glb(
        mesh, [](const GlbGeometry& geometry) { return described(encode(geometry), !geometry.colours.empty()); });
}

}  // namespace anyrate
