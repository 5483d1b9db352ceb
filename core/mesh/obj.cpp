#include "core/mesh/obj.h"

#include <cmath>
#include <limits>
#include <string>

#include "core/error.h"
#include "core/mesh/normals.h"
#include "core/mesh/text_scan.h"

namespace anyrate {
namespace {

template <class Number>
void put(std::string& text, Number value) {
    char digits[32];
    const auto result = std::to_chars(digits, digits + sizeof digits, value);
    text.push_back(' ');
    text.append(digits, result.ptr);
}

class ObjReader {
public:
    explicit ObjReader(std::string_view name) : name_(name) {}

    Mesh read(std::string_view text) {
        while (!text.empty()) {
            std::string_view rest = take_line(text);
            ++line_;
            const std::string_view word = take_word(rest);
            if (word == "v") add_vertex(rest);
            if (word == "f") add_polygon(rest);
        }
        if (mesh_.colours.size() != mesh_.vertices.size()) mesh_.colours.clear();
        for (const Triangle& t : mesh_.triangles)
            for (const auto v : t)
                if (v >= mesh_.n_vertices())
                    throw InputError(std::string(name_) + ": a face names vertex " + std::to_string(v + 1LL) + " of " +
                                     std::to_string(mesh_.n_vertices()));
        return std::move(mesh_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(std::string(name_) + ":" + std::to_string(line_) + ": " + what);
    }

    void add_vertex(std::string_view rest) {
        std::array<double, 6> column;
        std::size_t n = 0;
        for (std::string_view word = take_word(rest); !word.empty() && n < 6; word = take_word(rest)) {
            const auto value = parse_number<double>(word);
            if (!value || !std::isfinite(*value))
                fail("expected a number, got \"" + std::string(word.substr(0, 40)) + "\"");
            column[n++] = *value;
        }
        if (n < 3) fail("expected 3 coordinates, got " + std::to_string(n));
        mesh_.vertices.emplace_back(column[0], column[1], column[2]);
        const auto channel = [](double c) {
            return static_cast<std::uint8_t>(std::lround(255 * std::clamp(c, 0.0, 1.0)));
        };
        if (n == 6) mesh_.colours.push_back({channel(column[3]), channel(column[4]), channel(column[5])});
    }

    void add_polygon(std::string_view rest) {
        int n = 0;
        std::int32_t first = 0, previous = 0;
        for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest), ++n) {
            const std::int32_t corner = vertex_number(word);
            if (n == 0) first = corner;
            if (n >= 2) mesh_.triangles.push_back({first, previous, corner});
            previous = corner;
        }
        if (n < 3) fail("expected at least 3 corners of a face, got " + std::to_string(n));
    }

    /// The vertex of a corner "7", "7/1", "7/1/3" or "7//3", counted from 0.
    std::int32_t vertex_number(std::string_view corner) const {
        const auto number = parse_number<std::int32_t>(corner.substr(0, corner.find('/')));
        const std::int64_t v = !number ? -1 : *number > 0 ? *number - 1LL : *number + std::int64_t{mesh_.n_vertices()};
        if (!number || *number == 0 || v < 0)
            fail("expected a vertex number, got \"" + std::string(corner.substr(0, 40)) + "\"");
        return static_cast<std::int32_t>(v);
    }

    std::string_view name_;
    long long line_ = 0;
    Mesh mesh_;
};

}  // namespace

std::vector<std::byte> encode_obj(const Mesh& mesh) {
    std::string text;
    for (int v = 0; v < mesh.n_vertices(); ++v) {
        text += "v";
        for (const double x : mesh.vertices[v]) put(text, x);
        if (!mesh.colours.empty())
            for (const auto c : {mesh.colours[v].r, mesh.colours[v].g, mesh.colours[v].b})
                put(text, static_cast<float>(c) / 255.0F);
        text += "\n";
    }
    for (const Eigen::Vector3f& n : file_normals(mesh)) {
        text += "vn";
        for (const float x : n) put(text, std::round(x * 1e4F) / 1e4F);
        text += "\n";
    }
    for (const Triangle& t : mesh.triangles) {
        text += "f";
        for (const auto v : t) {
            put(text, v + 1);
            text += "//" + std::to_string(v + 1);
        }
        text += "\n";
    }
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

Mesh decode_obj(std::span<const std::byte> bytes, std::string_view name) {
    return ObjReader(name).read(as_text(bytes));
}

}  // namespace anyrate
