#include "proto/draco_io.h"

#include <draco/compression/config/compression_shared.h>
#include <draco/compression/expert_encode.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/point_cloud/point_cloud_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>

#include <memory>
#include <string>

#include "core/error.h"

namespace anyrate {

namespace {

// The start of every Draco string: "DRACO", version (2), geometry type, method, flags (2), then the geometry's own
// counts.
constexpr std::size_t version_offset = 5, type_offset = 7, method_offset = 8, flags_offset = 9, geometry_offset = 11;
constexpr std::size_t groups_offset = 15;  // of a point cloud: its number of groups of attributes
constexpr std::int32_t max_magnitude = 1 << 25;

[[noreturn]] void fail(const std::string& what) { throw DecodeError("Draco payload: " + what); }

bool in_range(std::int32_t value) { return value >= -max_magnitude && value <= max_magnitude; }

/// Whether a decoder that has read the attributes' descriptions, but no values, is about to make what was asked for.
bool has_layout(const draco::PointCloud& cloud, std::size_t n_points, std::span<const int> n_components) {
    if (cloud.num_points() != n_points || cloud.num_attributes() != static_cast<std::int32_t>(n_components.size())) {
        return false;
    }
    for (std::int32_t a = 0; a < cloud.num_attributes(); ++a) {
        const auto* attribute = cloud.attribute(a);
        if (attribute->data_type() != draco::DT_INT32 ||
            attribute->num_components() != n_components[static_cast<std::size_t>(a)]) {
            return false;
        }
    }
    return true;
}

/// Stock decoders that stop before they allocate values of another layout than the expected one.
template <class StockDecoder>
class CheckedDecoder final : public StockDecoder {
public:
    CheckedDecoder(std::size_t n_points, std::span<const int> n_components)
        : n_points_(n_points), n_components_(n_components) {}

protected:
    bool DecodeAllAttributes() override {
        return has_layout(*this->point_cloud(), n_points_, n_components_) && StockDecoder::DecodeAllAttributes();
    }

private:
    std::size_t n_points_;
    std::span<const int> n_components_;
};

/// @param minor  version 2.x of the bitstream: in those of others the counts stand elsewhere, and Draco reads them all
draco::DecoderBuffer open(std::span<const std::byte> bytes, draco::EncodedGeometryType type, int minor, int method) {
    if (bytes.size() < geometry_offset) fail("shorter than a Draco header");
    if (std::to_integer<int>(bytes[version_offset]) != 2 || std::to_integer<int>(bytes[version_offset + 1]) != minor) {
        fail("expected version 2." + std::to_string(minor) + " of the bitstream");
    }
    if (std::to_integer<int>(bytes[type_offset]) != static_cast<int>(type) ||
        std::to_integer<int>(bytes[method_offset]) != method) {
        fail("another geometry type or encoding method than the frame's");
    }
    if (bytes[flags_offset] != std::byte{0} || bytes[flags_offset + 1] != std::byte{0}) fail("unexpected metadata");
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return buffer;
}

/// Runs a decoder, turning every way in which Draco reports trouble into DecodeError.
template <class Decoder, class Geometry>
void run(Decoder& decoder, draco::DecoderBuffer& buffer, Geometry& geometry) {
    std::string trouble;
    try {
        const draco::DecoderOptions options;
        const draco::Status status = decoder.Decode(options, &buffer, &geometry);
        if (status.ok() && buffer.remaining_size() == 0) return;
        trouble = status.ok() ? "bytes behind its end" : status.error_msg_string();
    } catch (const std::exception& error) {
        trouble = error.what();
    }
    fail(trouble);
}

std::vector<std::int32_t> values_of(const draco::PointCloud& cloud, std::int32_t id) {
    const draco::PointAttribute& attribute = *cloud.attribute(id);
    const auto n = static_cast<std::size_t>(attribute.num_components());
    std::vector<std::int32_t> values(n * cloud.num_points());
    for (draco::PointIndex point(0); point < cloud.num_points(); ++point) {
        const auto entry = attribute.mapped_index(point);
        if (entry.value() >= attribute.size()) fail("a point without a value");
        attribute.GetValue(entry, values.data() + n * point.value());
    }
    for (const std::int32_t value : values) {
        if (!in_range(value)) fail("an integer beyond 2^25");
    }
    return values;
}

int add_attribute(draco::PointCloud& cloud, draco::GeometryAttribute::Type type, const IntAttribute& attribute) {
    const auto n = static_cast<std::size_t>(attribute.n_components);
    const std::size_t n_points = attribute.values.size() / n;
    draco::GeometryAttribute description;
    description.Init(type, nullptr, static_cast<std::uint8_t>(n), draco::DT_INT32, false,
                     static_cast<std::int64_t>(n * sizeof(std::int32_t)), 0);
    const int id = cloud.AddAttribute(description, true, static_cast<std::uint32_t>(n_points));
    for (std::size_t i = 0; i < n_points; ++i) {
        cloud.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(i)),
                                               attribute.values.data() + n * i);
    }
    return id;
}

std::vector<std::byte> encode(draco::ExpertEncoder& encoder) {
    draco::EncoderBuffer buffer;
    const draco::Status status = encoder.EncodeToBuffer(&buffer);
    if (!status.ok()) throw InputError("Draco encoder: " + status.error_msg_string());
    const auto* data = reinterpret_cast<const std::byte*>(buffer.data());
    return {data, data + buffer.size()};
}

/// Edgebreaker allocates by counts that stand at the front of its data: they must be those of the header.
void check_mesh_layout(draco::DecoderBuffer buffer, std::size_t n_vertices, std::size_t n_faces) {
    buffer.set_bitstream_version(DRACO_BITSTREAM_VERSION(2, 2));
    buffer.Advance(geometry_offset + 1);  // behind the traversal type
    std::uint32_t vertices = 0, faces = 0;
    if (!draco::DecodeVarint(&vertices, &buffer) || !draco::DecodeVarint(&faces, &buffer) || vertices != n_vertices ||
        faces != n_faces) {
        fail("expected a mesh of " + std::to_string(n_vertices) + " vertices and " + std::to_string(n_faces) +
             " faces");
    }
    std::uint8_t n_others = 0;
    if (!buffer.Decode(&n_others) || n_others != 0) fail("expected no attribute beside the position");
}

}  // namespace

std::vector<std::byte> encode_point_cloud(std::size_t n_points, std::span<const IntAttribute> attributes) {
    draco::PointCloud cloud;
    cloud.set_num_points(static_cast<std::uint32_t>(n_points));
    std::vector<int> ids;
    for (const IntAttribute& attribute : attributes) {
        for (const std::int32_t value : attribute.values) {
            if (!in_range(value)) throw InputError("stream: the integer " + std::to_string(value) + " exceeds 2^25");
        }
        ids.push_back(add_attribute(cloud, draco::GeometryAttribute::GENERIC, attribute));
    }
    draco::ExpertEncoder encoder(cloud);
    encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);  // the default, a kd-tree, reorders points
    for (const int id : ids) {
        const draco::Status status = encoder.SetAttributePredictionScheme(id, draco::PREDICTION_NONE);
        if (!status.ok()) throw InputError("Draco encoder: " + status.error_msg_string());
    }
    return encode(encoder);
}

std::vector<IntAttribute> decode_point_cloud(std::span<const std::byte> bytes, std::size_t n_points,
                                             std::span<const int> n_components) {
    draco::DecoderBuffer buffer = open(bytes, draco::POINT_CLOUD, 3, draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
    if (bytes.size() <= groups_offset || bytes[groups_offset] != std::byte{1}) fail("expected one group of attributes");
    CheckedDecoder<draco::PointCloudSequentialDecoder> decoder(n_points, n_components);
    draco::PointCloud cloud;
    run(decoder, buffer, cloud);
    std::vector<IntAttribute> attributes;
    for (std::size_t a = 0; a < n_components.size(); ++a) {
        attributes.push_back({n_components[a], values_of(cloud, static_cast<std::int32_t>(a))});
    }
    return attributes;
}

std::vector<std::byte> encode_draco_mesh(const BaseMesh& mesh) {
    draco::Mesh out;
    out.set_num_points(static_cast<std::uint32_t>(mesh.positions.size()));
    out.SetNumFaces(mesh.triangles.size());
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        const auto corner = [&](std::size_t i) {
            return draco::PointIndex(static_cast<std::uint32_t>(mesh.triangles[f][i]));
        };
        out.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(f)), {corner(0), corner(1), corner(2)});
    }
    IntAttribute positions{3, {}};
    for (const GridPoint& p : mesh.positions) positions.values.insert(positions.values.end(), {p.x, p.y, p.z});
    add_attribute(out, draco::GeometryAttribute::POSITION, positions);
    draco::ExpertEncoder encoder(out);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetSpeedOptions(0, 0);
    return encode(encoder);
}

BaseMesh decode_draco_mesh(std::span<const std::byte> bytes, std::size_t n_vertices, std::size_t n_faces) {
    draco::DecoderBuffer buffer = open(bytes, draco::TRIANGULAR_MESH, 2, draco::MESH_EDGEBREAKER_ENCODING);
    check_mesh_layout(buffer, n_vertices, n_faces);
    constexpr int three[] = {3};
    CheckedDecoder<draco::MeshEdgebreakerDecoder> decoder(n_vertices, three);
    draco::Mesh mesh;
    run(decoder, buffer, mesh);
    if (mesh.num_faces() != n_faces) fail("expected " + std::to_string(n_faces) + " faces");

    BaseMesh out;
    const std::vector<std::int32_t> xyz = values_of(mesh, 0);
    for (std::size_t i = 0; i < xyz.size(); i += 3) out.positions.push_back({xyz[i], xyz[i + 1], xyz[i + 2]});
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f) {
        const auto& face = mesh.face(f);
        const auto corner = [&](int i) { return static_cast<std::int32_t>(face[i].value()); };
        out.triangles.push_back({corner(0), corner(1), corner(2)});
    }
    return out;
}

}  // namespace anyrate
