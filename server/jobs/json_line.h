#pragma once
// A message between a server and its worker processes: one JSON object a line. Included by .cpp files only.
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.h"

namespace anyrate {

/// A file name inside an error sentence may be any bytes; what is not UTF-8 is replaced.
inline std::string json_line(const nlohmann::json& object) {
    return object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

/// The message that from_json(object) makes of a line.
/// @param what  the line is, for the error @throws DecodeError
template <class FromJson>
auto from_json_line(std::string_view line, const std::string& what, const FromJson& from_json) {
    try {
        return from_json(nlohmann::json::parse(line));
    } catch (const nlohmann::json::exception& error) {
        throw DecodeError(what + ": " + error.what());
    }
}

/// A whole number that an Integer can hold, to convert any other is undefined, and no less than `least`.
/// @throws DecodeError
template <class Integer>
Integer whole_number(const nlohmann::json& object, const std::string& key,
                     Integer least = std::numeric_limits<Integer>::min()) {
    const nlohmann::json& value = object.at(key);
    const bool fits = value.is_number_unsigned()
                          ? std::in_range<Integer>(value.get<std::uint64_t>())
                          : value.is_number_integer() && std::in_range<Integer>(value.get<std::int64_t>());
    if (!fits || value.get<Integer>() < least) throw DecodeError("message: " + key + " is no whole number in range");
    return value.get<Integer>();
}

}  // namespace anyrate
