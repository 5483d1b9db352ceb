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

/// The document and the one buffer it describes, built accessor by accessor.
class GlbBuilder {
public:
    /// Everything put into the buffer since the last call becomes an accessor of its own view; returns its number.
    int add_accessor(int target, int component_type, const char* type, int count) {
        const std::size_t length = buffer_.size() - view_begin_;
        json_["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", view_begin_}, {"byteLength", length}, {"target", target}});
        json_["accessors"].push_back({{"bufferView", json_["bufferViews"].size() - 1},
                                      {"componentType", component_type},
                                      {"count", count},
                                      {"type", type}});
        view_begin_ = buffer_.size();
        return static_cast<int>(json_["accessors"].size()) - 1;
    }

    int add_positions(const Mesh& mesh, const Vec3& origin) {
        Eigen::AlignedBox3f box;
        for (const Vec3& v : mesh.vertices) {
            const Eigen::Vector3f p = (v - origin).cast<float>();
            for (const float x : p) put_little_endian(buffer_, x);
            box.extend(p);
        }
        const int number = add_accessor(array_buffer, float32, "VEC3", mesh.n_vertices());
        const auto corner = [](const Eigen::Vector3f& p) { return Json::array({p.x(), p.y(), p.z()}); };
        json_["accessors"][number]["min"] = corner(box.min());
        json_["accessors"][number]["max"] = corner(box.max());
        return number;
    }

    int add_normals(const Mesh& mesh) {
        for (Vec3 n : vertex_normals(mesh)) {
            if (n.isZero()) n = Vec3::UnitZ();  // glTF knows unit normals only
            for (const double x : n) put_little_endian(buffer_, static_cast<float>(x));
        }
        return add_accessor(array_buffer, float32, "VEC3", mesh.n_vertices());
    }

    /// With an opaque alpha, so that each vertex takes eight bytes: views must be aligned to four.
    int add_colours(const Mesh& mesh) {
        for (const Rgb8 c : mesh.colours) {
            for (const auto channel : {c.r, c.g, c.b}) put_little_endian(buffer_, to_linear(channel));
            put_little_endian(buffer_, std::uint16_t{65535});
        }
        const int number = add_accessor(array_buffer, unsigned_short, "VEC4", mesh.n_vertices());
        json_["accessors"][number]["normalized"] = true;
        return number;
    }

    int add_indices(const Mesh& mesh) {
        for (const Triangle& t : mesh.triangles)
            for (const auto v : t) put_little_endian(buffer_, static_cast<std::uint32_t>(v));
        return add_accessor(element_array_buffer, unsigned_int, "SCALAR", 3 * mesh.n_faces());
    }

    Json& json() { return json_; }

    /// The file: 12 bytes of header, the document padded with spaces, the buffer (every view's length divides by 4).
    std::vector<std::byte> finish() {
        if (!buffer_.empty()) json_["buffers"] = Json::array({{{"byteLength", buffer_.size()}}});
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

    Json json_ = {{"asset", {{"version", "2.0"}, {"generator", "anyrate"}}}};
    std::vector<std::byte> buffer_;
    std::size_t view_begin_ = 0;
};

}  // namespace

std::vector<std::byte> encode_glb(const Mesh& mesh) {
    GlbBuilder builder;
    if (mesh.triangles.empty()) return builder.finish();
    Json node = {{"mesh", 0}};
    Vec3 origin = Vec3::Zero();
    if (!floats_suffice(mesh)) {
        origin = bounding_box(mesh).center();
        node["translation"] = {origin.x(), origin.y(), origin.z()};
    }
    Json attributes;
    attributes["POSITION"] = builder.add_positions(mesh, origin);
    attributes["NORMAL"] = builder.add_normals(mesh);
    if (!mesh.colours.empty()) attributes["COLOR_0"] = builder.add_colours(mesh);
    const int indices = builder.add_indices(mesh);
    Json& json = builder.json();
    json["scene"] = 0;
    json["scenes"] = Json::array({{{"nodes", {0}}}});
    json["nodes"] = Json::array({node});
    json["meshes"] = Json::array(
        {{{"primitives", Json::array({{{"attributes", attributes}, {"indices", indices}, {"material", 0}}})}}});
    // The default material is a metal, which shows its surroundings instead of its colour.
    json["materials"] = Json::array({{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}}});
    return builder.finish();
}

}  // namespace anyrate
