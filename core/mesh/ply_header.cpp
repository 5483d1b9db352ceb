#include "core/mesh/ply_header.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/error.h"
#include "core/mesh/text_scan.h"

namespace anyrate {
namespace {

/// No file needs as many; without a bound the search for equal names would take quadratic time.
constexpr std::size_t max_properties = 256;

class HeaderReader {
public:
    HeaderReader(std::string_view& text, std::string_view name) : text_(text), name_(name) {}

    PlyHeader read() {
        if (take_line(text_) != "ply") throw InputError(std::string(name_) + ": expected \"ply\" on the first line");
        PlyHeader header;
        bool has_format = false;
        while (!text_.empty()) {
            std::string_view rest = take_line(text_);
            ++line_;
            const std::string_view word = take_word(rest);
            if (word == "end_header" && has_format) return header;
            if (word == "format") {
                header.encoding = encoding(take_word(rest));
                has_format = true;
            } else if (word == "element") {
                header.elements.push_back(element(rest));
            } else if (word == "property") {
                if (header.elements.empty()) fail("expected an element before its properties");
                add_property(header.elements.back(), rest);
            } else if (word != "comment" && word != "obj_info" && !word.empty()) {
                fail("expected format, element, property, comment or end_header, got \"" + excerpt(word) + "\"");
            }
        }
        fail("the header ends without " + std::string(has_format ? "end_header" : "a format"));
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(std::string(name_) + ":" + std::to_string(line_) + ": " + what);
    }
    static std::string excerpt(std::string_view word) { return std::string(word.substr(0, 40)); }

    PlyEncoding encoding(std::string_view word) const {
        if (word == "ascii") return PlyEncoding::ascii;
        if (word == "binary_little_endian") return PlyEncoding::little_endian;
        if (word == "binary_big_endian") return PlyEncoding::big_endian;
        fail("expected format ascii, binary_little_endian or binary_big_endian, got \"" + excerpt(word) + "\"");
    }

    PlyElement element(std::string_view rest) const {
        PlyElement element;
        element.name = take_word(rest);
        const std::string_view count = take_word(rest);
        const auto value = parse_number<std::uint64_t>(count);
        if (!value) fail("expected the number of elements, got \"" + excerpt(count) + "\"");
        element.count = *value;
        return element;
    }

    PlyType type(std::string_view word) const {
        static constexpr std::array<std::pair<std::string_view, PlyType>, 16> types = {{{"char", PlyType::int8},
                                                                                        {"int8", PlyType::int8},
                                                                                        {"uchar", PlyType::uint8},
                                                                                        {"uint8", PlyType::uint8},
                                                                                        {"short", PlyType::int16},
                                                                                        {"int16", PlyType::int16},
                                                                                        {"ushort", PlyType::uint16},
                                                                                        {"uint16", PlyType::uint16},
                                                                                        {"int", PlyType::int32},
                                                                                        {"int32", PlyType::int32},
                                                                                        {"uint", PlyType::uint32},
                                                                                        {"uint32", PlyType::uint32},
                                                                                        {"float", PlyType::float32},
                                                                                        {"float32", PlyType::float32},
                                                                                        {"double", PlyType::float64},
                                                                                        {"float64", PlyType::float64}}};
        for (const auto& [spelling, value] : types)
            if (spelling == word) return value;
        fail("expected a number type such as float or uchar, got \"" + excerpt(word) + "\"");
    }

    void add_property(PlyElement& element, std::string_view rest) const {
        if (element.properties.size() == max_properties)
            fail("expected at most " + std::to_string(max_properties) + " properties of an element");
        PlyProperty property;
        std::string_view word = take_word(rest);
        if (word == "list") {
            property.is_list = true;
            property.count_type = type(take_word(rest));
            word = take_word(rest);
        }
        property.type = type(word);
        property.name = take_word(rest);
        const auto is_same = [&](const PlyProperty& other) { return other.name == property.name; };
        if (property.name.empty() || std::ranges::any_of(element.properties, is_same))
            fail("expected a new name for the property, got \"" + excerpt(property.name) + "\"");
        element.properties.push_back(std::move(property));
    }

    std::string_view& text_;
    std::string_view name_;
    int line_ = 1;
};

}  // namespace

std::size_t size_of(PlyType type) {
    switch (type) {
        case PlyType::int8:
        case PlyType::uint8:
            return 1;
        case PlyType::int16:
        case PlyType::uint16:
            return 2;
        case PlyType::float64:
            return 8;
        default:
            return 4;
    }
}

PlyHeader take_ply_header(std::string_view& text, std::string_view name) { return HeaderReader(text, name).read(); }

}  // namespace anyrate
