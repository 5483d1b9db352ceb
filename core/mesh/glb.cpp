#include "core/mesh/glb.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "core/mesh/bounds.h"
#include "core/mesh/little_endian.h"
#include "core/mesh/normals.h"

namespace anyrate {
namespace {

using Json = nlohmann::ordered_json;

// The numbers glTF has for component types, buffer targets and chunk types.
constexpr int unsigned_short = 5123, unsigned_int = 5125, float32 = 5126;
constexpr int array_buffer = 34962, element_array_buffer = 34963;
constexpr std::uint32_t glb_magic = 0x46546C67, json_chunk = 0x4E4F534A, bin_chunk = 0x004E4942;

/// A channel of sRGB (IEC 61966-2-1) as linear light, 65535 for 1.
std::uint16_t to_linear(std::uint8_t srgb) {
    const double c = srgb / 255.0;
    const double linear = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    return static_cast<std::uint16_t>(std::lround(65535 * linear));
}

GlbGeometry to_geometry(const Mesh& mesh, const Vec3& origin) {
    GlbGeometry geometry{.positions = {}, .normals = file_normals(mesh), .colours = {}, .triangles = mesh.triangles};
    for (const Vec3& v : mesh.vertices) geometry.positions.emplace_back((v - origin).cast<float>());
    for (const Rgb8 c : mesh.colours) geometry.colours.push_back({to_linear(c.r), to_linear(c.g), to_linear(c.b)});
    return geometry;
}

/// The document and the one buffer it describes, built view by view.
class GlbBuilder {
public:
    explicit GlbBuilder(const Vec3& origin) : origin_(origin) {}

    /// The geometry as it is, each attribute a view of its own.
    void add_plain(const GlbGeometry& geometry) {
        const int n_vertices = static_cast<int>(geometry.positions.size());
        Json attributes;
        attributes["POSITION"] = add_positions(geometry.positions);
        put_vectors(geometry.normals);
        attributes["NORMAL"] = add_accessor(add_view(array_buffer), float32, "VEC3", n_vertices);
        if (!geometry.colours.empty()) attributes["COLOR_0"] = add_colours(geometry);
        for (const Triangle& t : geometry.triangles)
            for (const auto v : t) put_little_endian(buffer_, static_cast<std::uint32_t>(v));
        const int n_indices = 3 * static_cast<int>(geometry.triangles.size());
        const int indices = add_accessor(add_view(element_array_buffer), unsigned_int, "SCALAR", n_indices);
        add_scene({{"attributes", attributes}, {"indices", indices}, {"material", 0}});
    }

    /// One view of Draco's bytes. The accessors have none: they say what a decoder will find.
    void add_compressed(const DracoGeometry& geometry) {
        constexpr const char* extension = "KHR_draco_mesh_compression";
        Json attributes, ids;
        const auto add = [&](const char* name, int id) {
            attributes[name] = add_accessor(std::nullopt, float32, "VEC3", geometry.n_vertices);
            ids[name] = id;
        };
        add("POSITION", geometry.position_id);
        set_bounds(attributes["POSITION"], geometry.bounds);
        add("NORMAL", geometry.normal_id);
        if (geometry.colour_id) add("COLOR_0", *geometry.colour_id);
        const int indices = add_accessor(std::nullopt, unsigned_int, "SCALAR", 3 * geometry.n_faces);
        buffer_.insert(buffer_.end(), geometry.bytes.begin(), geometry.bytes.end());
        const Json draco = {{"bufferView", add_view(std::nullopt)}, {"attributes", ids}};
        add_scene(
            {{"attributes", attributes}, {"indices", indices}, {"material", 0}, {"extensions", {{extension, draco}}}});
        json_["extensionsUsed"] = json_["extensionsRequired"] = Json::array({extension});
    }

    /// The file: 12 bytes of header, the document padded with spaces, the buffer padded with zeros.
    std::vector<std::byte> finish() {
        if (!buffer_.empty()) json_["buffers"] = Json::array({{{"byteLength", buffer_.size()}}});
        buffer_.resize((buffer_.size() + 3) / 4 * 4);
        std::string text = json_.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const std::size_t bin_size = buffer_.empty() ? 0 : 8 + buffer_.size();
        std::vector<std::byte> file;
        file.reserve(12 + 8 + text.size() + bin_size);
        put_numbers(file, {glb_magic, 2, static_cast<std::uint32_t>(12 + 8 + text.size() + bin_size)});
        put_numbers(file, {static_cast<std::uint32_t>(text.size()), json_chunk});
        for (const char c : text) file.push_back(static_cast<std::byte>(c));
        if (buffer_.empty()) return file;
        put_numbers(file, {static_cast<std::uint32_t>(buffer_.size()), bin_chunk});
        file.insert(file.end(), buffer_.begin(), buffer_.end());
        return file;
    }

private:
    static void put_numbers(std::vector<std::byte>& file, std::initializer_list<std::uint32_t> numbers) {
        for (const std::uint32_t n : numbers) put_little_endian(file, n);
    }

    void put_vectors(const std::vector<Eigen::Vector3f>& vectors) {
        for (const Eigen::Vector3f& v : vectors)
            for (const float x : v) put_little_endian(buffer_, x);
    }

    /// Everything put into the buffer since the last call; returns the view's number.
    int add_view(std::optional<int> target) {
        Json view = {{"buffer", 0}, {"byteOffset", view_begin_}, {"byteLength", buffer_.size() - view_begin_}};
        if (target) view["target"] = *target;
        json_["bufferViews"].push_back(view);
        view_begin_ = buffer_.size();
        return static_cast<int>(json_["bufferViews"].size()) - 1;
    }

    int add_accessor(std::optional<int> view, int component_type, const char* type, int count) {
        Json accessor;
        if (view) accessor["bufferView"] = *view;
        accessor.update({{"componentType", component_type}, {"count", count}, {"type", type}});
        json_["accessors"].push_back(accessor);
        return static_cast<int>(json_["accessors"].size()) - 1;
    }

    void set_bounds(int accessor, const Eigen::AlignedBox3f& box) {
        const auto corner = [](const Eigen::Vector3f& p) { return Json::array({p.x(), p.y(), p.z()}); };
        json_["accessors"][accessor]["min"] = corner(box.min());
        json_["accessors"][accessor]["max"] = corner(box.max());
    }

    int add_positions(const std::vector<Eigen::Vector3f>& positions) {
        put_vectors(positions);
        const int number = add_accessor(add_view(array_buffer), float32, "VEC3", static_cast<int>(positions.size()));
        Eigen::AlignedBox3f box;
        for (const Eigen::Vector3f& p : positions) box.extend(p);
        set_bounds(number, box);
        return number;
    }

    /// With an opaque alpha, so that each vertex takes eight bytes: views must be aligned to four.
    int add_colours(const GlbGeometry& geometry) {
        for (const auto& colour : geometry.colours) {
            for (const std::uint16_t channel : colour) put_little_endian(buffer_, channel);
            put_little_endian(buffer_, std::uint16_t{65535});
        }
        const int number =
            add_accessor(add_view(array_buffer), unsigned_short, "VEC4", static_cast<int>(geometry.colours.size()));
        json_["accessors"][number]["normalized"] = true;
        return number;
    }

    /// A scene of one node with one mesh of this primitive.
    void add_scene(const Json& primitive) {
        Json node = {{"mesh", 0}};
        if (!origin_.isZero()) node["translation"] = {origin_.x(), origin_.y(), origin_.z()};
        json_["scene"] = 0;
        json_["scenes"] = Json::array({{{"nodes", {0}}}});
        json_["nodes"] = Json::array({node});
        json_["meshes"] = Json::array({{{"primitives", Json::array({primitive})}}});
        // The default material is a metal, which shows its surroundings instead of its colour.
        json_["materials"] = Json::array({{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}}});
    }

    Vec3 origin_;
    Json json_ = {{"asset", {{"version", "2.0"}, {"generator", "anyrate"}}}};
    std::vector<std::byte> buffer_;
    std::size_t view_begin_ = 0;
};

Vec3 origin_of(const Mesh& mesh) {
    if (floats_suffice(mesh)) return Vec3::Zero();
    return bounding_box(mesh).center();
}

}  // namespace

std::vector<std::byte> encode_glb(const Mesh& mesh) {
    const Vec3 origin = origin_of(mesh);
    GlbBuilder builder(origin);
    if (!mesh.triangles.empty()) builder.add_plain(to_geometry(mesh, origin));
    return builder.finish();
}

std::vector<std::byte> encode_glb(const Mesh& mesh, const CompressGeometry& compress) {
    const Vec3 origin = origin_of(mesh);
    GlbBuilder builder(origin);
    if (!mesh.triangles.empty()) builder.add_compressed(compress(to_geometry(mesh, origin)));
    return builder.finish();
}

}  // namespace anyrate
