#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anyrate {

enum class PlyEncoding { ascii, little_endian, big_endian };
enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// Bytes of one number.
std::size_t size_of(PlyType type);

struct PlyProperty {
    std::string name;
    PlyType type{};        ///< of the value, or of a list's items
    bool is_list = false;  ///< a count, then so many items
    PlyType count_type{};
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;  ///< as the header claims: not to be believed before it is held against the bytes
    std::vector<PlyProperty> properties;
};

struct PlyHeader {
    PlyEncoding encoding{};
    std::vector<PlyElement> elements;
};

/// Reads a header and cuts it off the front of `text`. @param name of the file, for messages
/// @throws InputError
PlyHeader take_ply_header(std::string_view& text, std::string_view name);

}  // namespace anyrate
