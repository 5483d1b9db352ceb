#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>

#include "core/error.h"
#include "core/mesh/little_endian.h"
#include "core/mesh/ply.h"
#include "core/mesh/ply_header.h"
#include "core/mesh/text_scan.h"

namespace anyrate {
namespace {

/// Takes numbers from the front of a text body. The end of the text gives nullopt.
struct TextSource {
    std::string_view rest;

    std::optional<double> take(PlyType) { return parse_number<double>(take_word(rest)); }
    static std::size_t least_size(PlyType) { return 1; }
    bool at_end() const { return rest.find_first_not_of(" \t\r\n\v\f") == std::string_view::npos; }
};

/// Takes numbers from the front of a binary body.
struct BinarySource {
    std::string_view rest;
    std::endian order;

    template <class Number>
    double take_as() {
        std::array<char, sizeof(Number)> raw;
        std::memcpy(raw.data(), rest.data(), raw.size());
        rest.remove_prefix(raw.size());
        if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
        return static_cast<double>(std::bit_cast<Number>(raw));
    }
    std::optional<double> take(PlyType type) {
        if (rest.size() < size_of(type)) return std::nullopt;
        switch (type) {
            case PlyType::int8:
                return take_as<std::int8_t>();
            case PlyType::uint8:
                return take_as<std::uint8_t>();
            case PlyType::int16:
                return take_as<std::int16_t>();
            case PlyType::uint16:
                return take_as<std::uint16_t>();
            case PlyType::int32:
                return take_as<std::int32_t>();
            case PlyType::uint32:
                return take_as<std::uint32_t>();
            case PlyType::float32:
                return take_as<float>();
            case PlyType::float64:
                return take_as<double>();
        }
        return std::nullopt;
    }
    static std::size_t least_size(PlyType type) { return size_of(type); }
    bool at_end() const { return rest.empty(); }
};

/// Which property of the element has the name, and is a list or is none; -1 if there is no such.
int find_property(const PlyElement& element, std::string_view name, bool is_list) {
    for (std::size_t i = 0; i < element.properties.size(); ++i)
        if (element.properties[i].name == name && element.properties[i].is_list == is_list) return static_cast<int>(i);
    return -1;
}

template <class Source>
class BodyReader {
public:
    BodyReader(Source source, std::string_view name) : source_(source), name_(name) {}

    Mesh read(const PlyHeader& header) {
        for (const PlyElement& element : header.elements) {
            check_count(element);
            if (element.name == "vertex")
                read_vertices(element);
            else if (element.name == "face")
                read_faces(element);
            else
                skip(element);
        }
        if (!has_vertices_) fail("expected an element \"vertex\"");
        if (!source_.at_end()) fail("bytes follow the last element");
        for (const Triangle& t : mesh_.triangles)
            for (const auto v : t)
                if (v >= mesh_.n_vertices())
                    fail("a face names vertex " + std::to_string(v) + " of " + std::to_string(mesh_.n_vertices()));
        return std::move(mesh_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const { throw InputError(std::string(name_) + ": " + what); }

    /// Refuses more items than the bytes left could hold, before anything is allocated for them.
    void check_count(const PlyElement& element) const {
        std::size_t least = 0;
        for (const PlyProperty& p : element.properties) least += Source::least_size(p.is_list ? p.count_type : p.type);
        const bool fits = least == 0 || element.count <= source_.rest.size() / least;
        if (!fits || element.count > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()))
            fail("ends early: expected " + std::to_string(element.count) + " of element \"" + element.name + "\"");
    }

    double take(PlyType type) {
        const std::optional<double> value = source_.take(type);
        if (!value) fail("ends early, or holds what is no number");
        return *value;
    }

    /// Takes the count of a list.
    std::uint64_t take_count(const PlyProperty& property) {
        const double count = take(property.count_type);
        if (!(count >= 0 && count <= std::numeric_limits<std::uint32_t>::max()) || count != std::floor(count))
            fail("expected the length of list \"" + property.name + "\"");
        return static_cast<std::uint64_t>(count);
    }

    void skip(const PlyProperty& property) {
        for (std::uint64_t n = property.is_list ? take_count(property) : 1; n > 0; --n) take(property.type);
    }
    void skip(const PlyElement& element) {
        if (element.properties.empty()) return;
        for (std::uint64_t i = 0; i < element.count; ++i)
            for (const PlyProperty& property : element.properties) skip(property);
    }

    void read_vertices(const PlyElement& element) {
        if (has_vertices_) fail("expected one element \"vertex\", got two");
        has_vertices_ = true;
        std::vector<double> values(element.properties.size());
        const std::array<int, 3> position = {find_property(element, "x", false), find_property(element, "y", false),
                                             find_property(element, "z", false)};
        const std::array<int, 3> colour = {find_property(element, "red", false), find_property(element, "green", false),
                                           find_property(element, "blue", false)};
        if (std::ranges::min(position) < 0) fail("expected properties x, y and z of element \"vertex\"");
        const bool coloured =
            std::ranges::all_of(colour, [&](int i) { return i >= 0 && element.properties[i].type == PlyType::uint8; });
        mesh_.vertices.reserve(element.count);
        if (coloured) mesh_.colours.reserve(element.count);
        for (std::uint64_t v = 0; v < element.count; ++v) {
            for (std::size_t i = 0; i < values.size(); ++i) {
                const PlyProperty& property = element.properties[i];
                property.is_list ? skip(property) : void(values[i] = take(property.type));
            }
            const Vec3 point(values[position[0]], values[position[1]], values[position[2]]);
            if (!point.allFinite()) fail("vertex " + std::to_string(v) + " is not finite");
            mesh_.vertices.push_back(point);
            if (coloured)
                mesh_.colours.push_back(
                    {channel(values[colour[0]]), channel(values[colour[1]]), channel(values[colour[2]])});
        }
    }

    std::uint8_t channel(double value) const {
        if (!(value >= 0 && value <= 255)) fail("expected a colour of 0 to 255");
        return static_cast<std::uint8_t>(value);
    }

    void read_faces(const PlyElement& element) {
        int corners = find_property(element, "vertex_indices", true);
        if (corners < 0) corners = find_property(element, "vertex_index", true);
        if (corners < 0 && element.count > 0) fail("expected a list \"vertex_indices\" of element \"face\"");
        for (std::uint64_t f = 0; f < element.count; ++f)
            for (int i = 0; i < static_cast<int>(element.properties.size()); ++i)
                i == corners ? read_polygon(element.properties[i]) : skip(element.properties[i]);
    }

    /// A polygon as a fan about its first corner.
    void read_polygon(const PlyProperty& property) {
        const std::uint64_t n = take_count(property);
        if (n < 3) fail("expected at least 3 corners of a face, got " + std::to_string(n));
        const std::int32_t first = take_index(property.type);
        std::int32_t previous = take_index(property.type);
        for (std::uint64_t i = 2; i < n; ++i) {
            const std::int32_t corner = take_index(property.type);
            mesh_.triangles.push_back({first, previous, corner});
            previous = corner;
        }
    }

    std::int32_t take_index(PlyType type) {
        const double value = take(type);
        if (!(value >= 0 && value <= std::numeric_limits<std::int32_t>::max()) || value != std::floor(value))
            fail("a face names a vertex that cannot be");
        return static_cast<std::int32_t>(value);
    }

    Source source_;
    std::string_view name_;
    Mesh mesh_;
    bool has_vertices_ = false;
};

}  // namespace

Mesh decode_ply(std::span<const std::byte> bytes, std::string_view name) {
    std::string_view text = as_text(bytes);
    const PlyHeader header = take_ply_header(text, name);
    if (header.encoding == PlyEncoding::ascii) return BodyReader(TextSource{text}, name).read(header);
    const auto order = header.encoding == PlyEncoding::big_endian ? std::endian::big : std::endian::little;
    return BodyReader(BinarySource{text, order}, name).read(header);
}

}  // namespace anyrate
