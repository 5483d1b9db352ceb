#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <type_traits>

namespace anyrate {

/// Accepts the names of an enumeration's values, and nothing else: a number is wrong usage.
template <class Value>
CLI::Validator one_of(const std::map<std::string, Value>& values) {
    std::string names;
    for (const auto& [name, value] : values) names += (names.empty() ? "" : "|") + name;
    const auto by_name = [values, names](std::string& text) -> std::string {
        const auto found = values.find(text);
        if (found == values.end()) return "expected " + names + ", got " + text;
        if constexpr (std::is_enum_v<Value>)  // the library reads enumerations as numbers
            text = std::to_string(static_cast<std::underlying_type_t<Value>>(found->second));
        return {};
    };
    return CLI::Validator(by_name, names, "one of");
}

}  // namespace anyrate
